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

// A file of a few kilobytes can claim a picture of any size.
constexpr std::uint64_t largest_picture_bytes = std::uint64_t{1} << 30;
// Deflate makes at most 1032 bytes of one, of eight pixels each (zlib.net/zlib_tech.html).
constexpr std::uint64_t most_pixels_per_byte = 1032 * 8;

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

Image read_png(const std::filesystem::path& path) {
  PngImage png;
  if (png_image_begin_read_from_file(&png, path.c_str()) == 0) {
    throw FileError(fmt::format("{}: cannot be read: {}", path.string(), png.message));
  }
  const bool alpha = (png.format & PNG_FORMAT_FLAG_ALPHA) != 0;
  const bool color = (png.format & PNG_FORMAT_FLAG_COLOR) != 0;
  png.format = alpha ? PNG_FORMAT_RGBA : color ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
  Image image;
  image.channels = alpha ? 4 : color ? 3 : 1;
  const std::uint64_t size =
      std::uint64_t(png.width) * png.height * static_cast<std::uint64_t>(image.channels);
  if (size > largest_picture_bytes) {
    throw FileError(
        fmt::format("{}: a picture of {} x {} is too large", path.string(), png.width, png.height));
  }
  // A header alone must not take memory.
  if (size / static_cast<std::uint64_t>(image.channels) >
      most_pixels_per_byte * std::filesystem::file_size(path)) {
    throw FileError(fmt::format("{}: the file is too short for a picture of {} x {}", path.string(),
                                png.width, png.height),
                    "the file is damaged");
  }
  image.width = static_cast<int>(png.width);
  image.height = static_cast<int>(png.height);
  image.pixels.resize(size);
  if (png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr) == 0) {
    throw FileError(fmt::format("{}: cannot be read: {}", path.string(), png.message));
  }
  return image;
}

}  // namespace carillon::core
