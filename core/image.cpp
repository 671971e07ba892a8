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

}  // namespace

void write_png(const std::filesystem::path& path, const Image& image) {
  const bool known = image.channels == 1 || image.channels == 3 || image.channels == 4;
  const std::uint64_t size =
      known && image.width > 0 && image.height > 0
          ? std::uint64_t(image.width) * std::uint64_t(image.height) * std::uint64_t(image.channels)
          : 0;
  if (size == 0 || size != image.pixels.size()) {
    throw FileError(fmt::format("{}: a picture of {} x {} with {} channels cannot hold {} bytes",
                                path.string(), image.width, image.height, image.channels,
                                image.pixels.size()));
  }
  PngImage png;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = image.channels == 1   ? PNG_FORMAT_GRAY
               : image.channels == 3 ? PNG_FORMAT_RGB
                                     : PNG_FORMAT_RGBA;
  if (png_image_write_to_file(&png, path.c_str(), 0, image.pixels.data(), 0, nullptr) == 0) {
    throw FileError(fmt::format("{}: cannot be written: {}", path.string(), png.message));
  }
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
  image.width = static_cast<int>(png.width);
  image.height = static_cast<int>(png.height);
  image.pixels.resize(size);
  if (png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr) == 0) {
    throw FileError(fmt::format("{}: cannot be read: {}", path.string(), png.message));
  }
  return image;
}

}  // namespace carillon::core
