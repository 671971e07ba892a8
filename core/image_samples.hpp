#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace carillon::core {

/// Numbers of a picture as its file has them, rows from top to bottom: no gamma, nothing multiplied
/// by alpha. For pictures that hold data.
struct ImageSamples {
  int width = 0;
  int height = 0;
  int channels = 1;  ///< grey; grey and alpha; red, green, blue; and alpha
  int bits = 16;     ///< 8 or 16: values go to 255 or 65,535
  std::vector<std::uint16_t> values;
};

/// @throws FileError
void write_png_samples(const std::filesystem::path& path, const ImageSamples& image);
/// Any PNG; palettes and fewer bits than 8 come as 8 bits.
/// @throws FileError
ImageSamples read_png_samples(const std::filesystem::path& path);

}  // namespace carillon::core
