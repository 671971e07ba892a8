#include "core/image_samples.hpp"

#include <fmt/format.h>
#include <png.h>

#include <array>
#include <csetjmp>
#include <cstdio>
#include <memory>
#include <string>

#include "core/error.hpp"

namespace carillon::core {

namespace {

constexpr std::uint64_t largest_samples_bytes = std::uint64_t{1} << 30;
constexpr int largest_side = 1 << 20;
// Deflate makes at most 1032 bytes of one, of eight pixels each (zlib.net/zlib_tech.html).
constexpr std::uint64_t max_pixels_per_byte = 1032 * 8;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// Everything a jump out of libpng leaves behind lies here, outside the functions that it leaves.
struct Png {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::string complaint;
  bool writes = false;

  explicit Png(bool writing) : writes(writing) {
    png = writing ? png_create_write_struct(PNG_LIBPNG_VER_STRING, this, failed, silent)
                  : png_create_read_struct(PNG_LIBPNG_VER_STRING, this, failed, silent);
    info = png == nullptr ? nullptr : png_create_info_struct(png);
    if (info == nullptr) throw MemoryError("no memory for a picture");
  }
  ~Png() {
    if (writes) {
      png_destroy_write_struct(&png, &info);
    } else {
      png_destroy_read_struct(&png, &info, nullptr);
    }
  }
  Png(const Png&) = delete;
  Png& operator=(const Png&) = delete;

  static void failed(png_structp png, png_const_charp reason) {
    static_cast<Png*>(png_get_error_ptr(png))->complaint = reason;
    png_longjmp(png, 1);
  }
  static void silent(png_structp, png_const_charp) {}
};

// A C++ exception may not cross libpng, so that its errors are jumps: in the functions that call
// setjmp nothing has a destructor.

bool read_header(Png& state, std::FILE* file) {
  if (setjmp(png_jmpbuf(state.png)) != 0) return false;
  png_init_io(state.png, file);
  png_set_user_limits(state.png, largest_side, largest_side);
  png_read_info(state.png, state.info);
  png_set_expand(state.png);  // palettes, few bits, a transparent color
  png_set_interlace_handling(state.png);
  png_read_update_info(state.png, state.info);
  return true;
}

bool read_rows(Png& state, png_bytepp rows) {
  if (setjmp(png_jmpbuf(state.png)) != 0) return false;
  png_read_image(state.png, rows);
  png_read_end(state.png, nullptr);
  return true;
}

bool write_all(Png& state, std::FILE* file, const ImageSamples& image, png_bytepp rows) {
  if (setjmp(png_jmpbuf(state.png)) != 0) return false;
  constexpr std::array<int, 4> types = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA,
                                        PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
  png_init_io(state.png, file);
  png_set_IHDR(state.png, state.info, static_cast<png_uint_32>(image.width),
               static_cast<png_uint_32>(image.height), image.bits,
               types[static_cast<std::size_t>(image.channels - 1)], PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(state.png, state.info);
  png_write_image(state.png, rows);
  png_write_end(state.png, nullptr);
  return true;
}

std::vector<png_bytep> rows_of(std::vector<png_byte>& bytes, int height) {
  std::vector<png_bytep> rows;
  const std::size_t stride = bytes.size() / static_cast<std::size_t>(height);
  for (int row = 0; row < height; ++row) {
    rows.push_back(bytes.data() + stride * static_cast<std::size_t>(row));
  }
  return rows;
}

}  // namespace

void write_png_samples(const std::filesystem::path& path, const ImageSamples& image) {
  const bool known = image.channels >= 1 && image.channels <= 4 && image.width > 0 &&
                     image.height > 0 && image.width <= largest_side &&
                     image.height <= largest_side && (image.bits == 8 || image.bits == 16);
  const std::uint64_t count = known ? std::uint64_t(image.width) * std::uint64_t(image.height) *
                                          std::uint64_t(image.channels)
                                    : 0;
  if (count == 0 || count != image.values.size()) {
    throw FileError(fmt::format(
        "{}: a picture of {} x {} with {} channels of {} bits cannot hold {} values", path.string(),
        image.width, image.height, image.channels, image.bits, image.values.size()));
  }
  std::vector<png_byte> bytes;
  bytes.reserve(count * static_cast<std::uint64_t>(image.bits / 8));
  for (const std::uint16_t value : image.values) {
    if (image.bits == 16) bytes.push_back(static_cast<png_byte>(value >> 8));
    bytes.push_back(static_cast<png_byte>(value & 0xff));
  }
  std::vector<png_bytep> rows = rows_of(bytes, image.height);
  File file(std::fopen(path.c_str(), "wb"));
  if (!file) throw FileError(fmt::format("{}: cannot be written", path.string()));
  Png state(true);
  if (!write_all(state, file.get(), image, rows.data()) || std::fclose(file.release()) != 0) {
    throw FileError(fmt::format("{}: cannot be written{}{}", path.string(),
                                state.complaint.empty() ? "" : ": ", state.complaint));
  }
}

ImageSamples read_png_samples(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw FileError(fmt::format("{}: no such file", path.string()));
  }
  const File file(std::filesystem::is_regular_file(path, ignored) ? std::fopen(path.c_str(), "rb")
                                                                  : nullptr);
  if (!file) throw FileError(fmt::format("{}: cannot be read", path.string()));
  Png state(false);
  if (!read_header(state, file.get())) {
    throw FileError(fmt::format("{}: cannot be read as PNG: {}", path.string(), state.complaint));
  }
  ImageSamples image;
  image.width = static_cast<int>(png_get_image_width(state.png, state.info));
  image.height = static_cast<int>(png_get_image_height(state.png, state.info));
  image.channels = png_get_channels(state.png, state.info);
  image.bits = png_get_bit_depth(state.png, state.info);
  const std::uint64_t stride = png_get_rowbytes(state.png, state.info);
  const std::uint64_t size = stride * static_cast<std::uint64_t>(image.height);
  if (size > largest_samples_bytes) {
    throw FileError(fmt::format("{}: a picture of {} x {} is too large", path.string(), image.width,
                                image.height));
  }
  // A header alone must not take memory.
  if (std::uint64_t(image.width) * std::uint64_t(image.height) >
      max_pixels_per_byte * std::filesystem::file_size(path)) {
    throw FileError(fmt::format("{}: the file is too short for a picture of {} x {}", path.string(),
                                image.width, image.height),
                    "the file is damaged");
  }
  std::vector<png_byte> bytes(size);
  std::vector<png_bytep> rows = rows_of(bytes, image.height);
  if (!read_rows(state, rows.data())) {
    throw FileError(fmt::format("{}: cannot be read as PNG: {}", path.string(), state.complaint));
  }
  if (image.bits == 16) {
    image.values.resize(size / 2);
    for (std::size_t i = 0; i < image.values.size(); ++i) {
      image.values[i] = static_cast<std::uint16_t>(bytes[2 * i] << 8 | bytes[2 * i + 1]);
    }
  } else {
    image.values.assign(bytes.begin(), bytes.end());
  }
  return image;
}

}  // namespace carillon::core
