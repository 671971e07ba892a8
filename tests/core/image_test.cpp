#include "core/image.hpp"

#include <gtest/gtest.h>
#include <png.h>
#include <rapidcheck.h>

#include <fstream>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

Image checkered(int width, int height, int channels) {
  Image image{width, height, channels, {}};
  for (int i = 0; i < width * height * channels; ++i) {
    image.pixels.push_back(static_cast<std::uint8_t>(37 * i + i / 7));
  }
  return image;
}

TEST(WritePng, KeepsEveryPixel) {
  const TemporaryFolder folder;
  for (int channels : {1, 3, 4}) {
    const Image image = checkered(17, 9, channels);
    write_png(folder / "a.png", image);
    const Image back = read_png(folder / "a.png");
    EXPECT_EQ(back.width, 17);
    EXPECT_EQ(back.height, 9);
    EXPECT_EQ(back.channels, channels);
    EXPECT_EQ(back.pixels, image.pixels);
  }
}

TEST(PngBytes, AreThoseOfTheFile) {
  const TemporaryFolder folder;
  for (int channels : {1, 3, 4}) {
    const Image image = checkered(17, 9, channels);
    write_png(folder / "a.png", image);
    EXPECT_EQ(png_bytes("a", image), read_file(folder / "a.png"));
  }
  EXPECT_THROW(png_bytes("a", {2, 2, 3, {1, 2, 3}}), FileError);
}

TEST(WritePng, RowsGoFromTopToBottom) {
  const TemporaryFolder folder;
  write_png(folder / "a.png", {1, 2, 3, {255, 0, 0, 0, 0, 255}});
  // libpng's own reader, rows by its definition.
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&png, (folder / "a.png").c_str()), 0);
  png.format = PNG_FORMAT_RGB;
  std::uint8_t pixels[6];
  ASSERT_NE(png_image_finish_read(&png, nullptr, pixels, 0, nullptr), 0);
  EXPECT_EQ(pixels[0], 255);
  EXPECT_EQ(pixels[5], 255);
}

TEST(WritePng, EqualPixelsGiveEqualBytes) {
  const TemporaryFolder folder;
  write_png(folder / "a.png", checkered(40, 30, 3));
  write_png(folder / "b.png", checkered(40, 30, 3));
  EXPECT_EQ(sha256_file(folder / "a.png"), sha256_file(folder / "b.png"));
}

TEST(WritePng, RefusesWhatIsNoPicture) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_png(folder / "a.png", {0, 5, 3, {}}), FileError);
  EXPECT_THROW(write_png(folder / "a.png", {-1, -1, 1, {0}}), FileError);
  EXPECT_THROW(write_png(folder / "a.png", {2, 2, 3, std::vector<std::uint8_t>(11)}), FileError);
  EXPECT_THROW(write_png(folder / "a.png", {1, 1, 2, {0, 0}}), FileError);
  EXPECT_THROW(write_png(folder / "absent/a.png", checkered(2, 2, 3)), FileError);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.png"));
}

TEST(ReadPng, TakesSixteenBitsAndGrayWithAlpha) {
  const TemporaryFolder folder;
  const auto write = [&](png_uint_32 format, const void* pixels) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = png.height = 1;
    png.format = format;
    ASSERT_NE(png_image_write_to_file(&png, (folder / "a.png").c_str(), 0, pixels, 0, nullptr), 0);
  };
  const std::uint16_t linear[3] = {65535, 0, 65535};
  write(PNG_FORMAT_LINEAR_RGB, linear);
  EXPECT_EQ(read_png(folder / "a.png").pixels, (std::vector<std::uint8_t>{255, 0, 255}));
  const std::uint8_t gray_alpha[2] = {90, 120};
  write(PNG_FORMAT_GA, gray_alpha);
  const Image image = read_png(folder / "a.png");
  EXPECT_EQ(image.channels, 4);
  EXPECT_EQ(image.pixels, (std::vector<std::uint8_t>{90, 90, 90, 120}));
}

TEST(ReadPng, NamesTheFileAndTheReason) {
  const TemporaryFolder folder;
  write_text_durably(folder / "text.png", "no picture");
  for (const char* name : {"absent.png", "text.png"}) {
    try {
      read_png(folder / name);
      FAIL() << name;
    } catch (const FileError& error) {
      EXPECT_NE(error.message().find(std::string(name) + ": cannot be read: "), std::string::npos)
          << error.message();
    }
  }
}

/// CRC-32 of a PNG chunk (ISO 3309).
std::uint32_t crc_of(std::string_view bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc;
}

TEST(ReadPng, AHeaderAloneTakesNoMemory) {
  const TemporaryFolder folder;
  write_png(folder / "a.png", checkered(4, 4, 1));
  std::string bytes = read_file(folder / "a.png");
  const std::size_t header = bytes.find("IHDR");
  ASSERT_EQ(header, 12u);
  const auto put = [&](std::size_t at, std::uint32_t value) {
    for (int k = 0; k < 4; ++k) bytes[at + k] = static_cast<char>(value >> (24 - 8 * k));
  };
  put(header + 4, 30000);
  put(header + 8, 30000);
  put(header + 17, crc_of(std::string_view(bytes).substr(header, 17)));
  write_text_durably(folder / "large.png", bytes);
  try {
    read_png(folder / "large.png");
    FAIL() << "read";
  } catch (const FileError& error) {
    EXPECT_NE(error.message().find("too short for a picture of 30000 x 30000"), std::string::npos)
        << error.message();
  }
}

TEST(ReadPng, DamagedFilesGiveAPictureOrAnError) {
  const TemporaryFolder folder;
  write_png(folder / "good.png", checkered(20, 20, 3));
  const std::string good = read_file(folder / "good.png");
  EXPECT_TRUE(rc::check([&] {
    std::string bytes = good.substr(0, *rc::gen::inRange<std::size_t>(0, good.size() + 1));
    for (int i = *rc::gen::inRange(0, 4); i > 0 && !bytes.empty(); --i) {
      bytes[*rc::gen::inRange<std::size_t>(0, bytes.size())] =
          static_cast<char>(*rc::gen::inRange(0, 256));
    }
    std::ofstream(folder / "damaged.png", std::ios::binary) << bytes;
    try {
      const Image image = read_png(folder / "damaged.png");
      RC_ASSERT(image.pixels.size() ==
                std::size_t(image.width) * std::size_t(image.height) * std::size_t(image.channels));
    } catch (const FileError& error) {
      RC_ASSERT(!error.message().empty());
    }
  }));
}

}  // namespace
}  // namespace carillon::core
