#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace carillon::core {

/// Picture to be looked at, rows from top to bottom, `channels` bytes (1, 3 or 4; sRGB) per pixel.
/// One that holds data is an ImageSamples.
struct Image {
  int width = 0;
  int height = 0;
  int channels = 3;
  std::vector<std::uint8_t> pixels;
};

/// @throws FileError
void write_png(const std::filesystem::path& path, const Image& image);
/// The bytes of that file.
std::string png_bytes(const std::string& name, const Image& image);

}  // namespace carillon::core
