#include "core/image_samples.hpp"

#include <gtest/gtest.h>
#include <png.h>
#include <rapidcheck.h>

#include <fstream>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

TEST(ImageSamples, ComeBackAsTheyWereWritten) {
  const TemporaryFolder folder;
  for (const int bits : {8, 16}) {
    for (int channels = 1; channels <= 4; ++channels) {
      ImageSamples image{7, 5, channels, bits, {}};
      for (int i = 0; i < 35 * channels; ++i) {
        image.values.push_back(static_cast<std::uint16_t>(i * 7919 % (1 << bits)));
      }
      write_png_samples(folder / "a.png", image);
      const ImageSamples back = read_png_samples(folder / "a.png");
      EXPECT_EQ(back.width, 7);
      EXPECT_EQ(back.height, 5);
      EXPECT_EQ(back.channels, channels);
      EXPECT_EQ(back.bits, bits);
      EXPECT_EQ(back.values, image.values);
    }
  }
}

// libpng's own writer stores linear light of 16 bits as it is given, and says so in the file.
TEST(ImageSamples, AreTheFilesNumbersWhateverItSaysOfThem) {
  const TemporaryFolder folder;
  const std::vector<std::uint16_t> linear = {0, 1, 258, 32768, 40000, 65535};
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = 2;
  png.height = 1;
  png.format = PNG_FORMAT_LINEAR_RGB;
  ASSERT_NE(png_image_write_to_file(&png, (folder / "a.png").c_str(), 0, linear.data(), 0, nullptr),
            0);
  const ImageSamples image = read_png_samples(folder / "a.png");
  EXPECT_EQ(image.bits, 16);
  EXPECT_EQ(image.values, linear);
  // Colours under full transparency stay, too.
  write_png_samples(folder / "b.png", {1, 1, 4, 8, {10, 20, 30, 0}});
  EXPECT_EQ(read_png_samples(folder / "b.png").values, (std::vector<std::uint16_t>{10, 20, 30, 0}));
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

TEST(ImageSamples, AHeaderAloneTakesNoMemory) {
  const TemporaryFolder folder;
  write_png_samples(folder / "a.png", {4, 4, 1, 8, std::vector<std::uint16_t>(16)});
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
    read_png_samples(folder / "large.png");
    FAIL() << "read";
  } catch (const FileError& error) {
    EXPECT_NE(error.message().find("too short for a picture of 30000 x 30000"), std::string::npos)
        << error.message();
  }
}

TEST(ImageSamples, OfDamagedFilesAreAPictureOrAnError) {
  const TemporaryFolder folder;
  ImageSamples image{20, 20, 3, 8, {}};
  for (int i = 0; i < 1200; ++i) image.values.push_back(static_cast<std::uint16_t>(37 * i % 256));
  write_png_samples(folder / "good.png", image);
  const std::string good = read_file(folder / "good.png");
  EXPECT_TRUE(rc::check([&] {
    std::string bytes = good.substr(0, *rc::gen::inRange<std::size_t>(0, good.size() + 1));
    for (int i = *rc::gen::inRange(0, 4); i > 0 && !bytes.empty(); --i) {
      bytes[*rc::gen::inRange<std::size_t>(0, bytes.size())] =
          static_cast<char>(*rc::gen::inRange(0, 256));
    }
    std::ofstream(folder / "damaged.png", std::ios::binary) << bytes;
    try {
      const ImageSamples read = read_png_samples(folder / "damaged.png");
      RC_ASSERT(read.values.size() ==
                std::size_t(read.width) * std::size_t(read.height) * std::size_t(read.channels));
    } catch (const FileError& error) {
      RC_ASSERT(!error.message().empty());
    }
  }));
}

TEST(ImageSamples, RefuseWhatIsNoPicture) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_png_samples(folder / "a.png", {0, 1, 1, 8, {}}), FileError);
  EXPECT_THROW(write_png_samples(folder / "a.png", {1, 1, 5, 8, {0, 0, 0, 0, 0}}), FileError);
  EXPECT_THROW(write_png_samples(folder / "a.png", {1, 1, 1, 12, {0}}), FileError);
  EXPECT_THROW(write_png_samples(folder / "a.png", {1, 2, 1, 8, {0}}), FileError);
  EXPECT_THROW(write_png_samples(folder / "no/a.png", {1, 1, 1, 8, {0}}), FileError);
  EXPECT_THROW(read_png_samples(folder / "a.png"), FileError);
  EXPECT_THROW(read_png_samples(folder / "."), FileError);
}

}  // namespace
}  // namespace carillon::core
