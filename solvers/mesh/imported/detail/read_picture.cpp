#include "solvers/mesh/imported/detail/read_picture.hpp"

#include <fmt/core.h>
#include <png.h>
#include <turbojpeg.h>

#include <memory>

#include "core/error.hpp"

namespace carillon::solvers::mesh::imported {

namespace {

constexpr std::int64_t largest_picture = 64 << 20;  // [pixel]

core::Image picture_of(const std::string& name, std::int64_t width, std::int64_t height) {
  if (width < 1 || height < 1 || width * height > largest_picture) {
    throw core::InputError(
        fmt::format("{}: a picture of {} x {} pixels is not read", name, width, height),
        "make it smaller: 4096 x 4096 pixels show all that a frame does");
  }
  core::Image image{static_cast<int>(width), static_cast<int>(height), 3, {}};
  image.pixels.resize(static_cast<std::size_t>(3 * width * height));
  return image;
}

core::Image read_png(const std::string& name, std::string_view bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, void (*)(png_image*)> released(&png, png_image_free);
  const auto fail = [&] {
    throw core::InputError(fmt::format("{}: cannot be read as PNG: {}", name, png.message));
  };
  if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0) fail();
  core::Image image = picture_of(name, png.width, png.height);
  // What is transparent has a colour, too.
  png.format = PNG_FORMAT_RGBA;
  std::vector<std::uint8_t> pixels(image.pixels.size() / 3 * 4);
  if (png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr) == 0) fail();
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = pixels[i / 3 * 4 + i % 3];
  return image;
}

core::Image read_jpeg(const std::string& name, std::string_view bytes) {
  const std::unique_ptr<void, int (*)(tjhandle)> reader(tjInitDecompress(), tjDestroy);
  const auto fail = [&] {
    throw core::InputError(
        fmt::format("{}: cannot be read as JPEG: {}", name, tjGetErrorStr2(reader.get())));
  };
  if (!reader) fail();
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0, height = 0, sampling = 0, colours = 0;
  if (tjDecompressHeader3(reader.get(), data, bytes.size(), &width, &height, &sampling, &colours) !=
      0) {
    fail();
  }
  core::Image image = picture_of(name, width, height);
  // A file that is cut off gives what there is of it, and a warning.
  if (tjDecompress2(reader.get(), data, bytes.size(), image.pixels.data(), width, 3 * width, height,
                    TJPF_RGB, 0) != 0 &&
      tjGetErrorCode(reader.get()) != TJERR_WARNING) {
    fail();
  }
  return image;
}

}  // namespace

core::Image read_picture(const std::string& name, std::string_view bytes) {
  if (bytes.starts_with("\x89PNG")) return read_png(name, bytes);
  if (bytes.starts_with("\xff\xd8")) return read_jpeg(name, bytes);
  throw core::InputError(fmt::format("{}: no PNG and no JPEG file", name));
}

}  // namespace carillon::solvers::mesh::imported
