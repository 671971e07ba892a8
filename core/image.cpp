#include "core/image.hpp"

#include <fmt/format.h>
#include <png.h>

#include "core/error.hpp"

namespace carillon::core {

namespace {

/// libpng's simplified interface; its state is freed on every way out.
struct PngImage : png_image {
  PngImage() : png_image{} { version = PNG_IMAGE_VERSION; }
  ~PngImage() { png_image_free(this); }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;
};

/// What libpng is told of a picture.
/// @param name  for messages
void describe(PngImage& png, const std::string& name, const Image& image) {
  const bool known = image.channels == 1 || image.channels == 3 || image.channels == 4;
  const std::uint64_t size =
      known && image.width > 0 && image.height > 0
          ? std::uint64_t(image.width) * std::uint64_t(image.height) * std::uint64_t(image.channels)
          : 0;
  if (size == 0 || size != image.pixels.size()) {
    throw FileError(fmt::format("{}: a picture of {} x {} with {} channels cannot hold {} bytes",
                                name, image.width, image.height, image.channels,
                                image.pixels.size()));
  }
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = image.channels == 1   ? PNG_FORMAT_GRAY
               : image.channels == 3 ? PNG_FORMAT_RGB
                                     : PNG_FORMAT_RGBA;
}

}  // namespace

void write_png(const std::filesystem::path& path, const Image& image) {
  PngImage png;
  describe(png, path.string(), image);
  if (png_image_write_to_file(&png, path.c_str(), 0, image.pixels.data(), 0, nullptr) == 0) {
    throw FileError(fmt::format("{}: cannot be written: {}", path.string(), png.message));
  }
}

std::string png_bytes(const std::string& name, const Image& image) {
  PngImage png;
  describe(png, name, image);
  png_alloc_size_t size = 0;
  std::string bytes;
  // Once for the size, once for the bytes.
  for (int pass = 0; pass < 2; ++pass) {
    bytes.resize(size);
    void* memory = pass == 0 ? nullptr : bytes.data();
    if (png_image_write_to_memory(&png, memory, &size, 0, image.pixels.data(), 0, nullptr) == 0) {
      throw FileError(fmt::format("{}: cannot be packed: {}", name, png.message));
    }
  }
  return bytes;
}

}  // namespace carillon::core
