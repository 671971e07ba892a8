#include "core/image.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/image_samples.hpp"
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
    const ImageSamples back = read_png_samples(folder / "a.png");
    EXPECT_EQ(back.width, 17);
    EXPECT_EQ(back.height, 9);
    EXPECT_EQ(back.channels, channels);
    EXPECT_EQ(back.bits, 8);
    EXPECT_EQ(back.values, (std::vector<std::uint16_t>(image.pixels.begin(), image.pixels.end())));
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

}  // namespace
}  // namespace carillon::core
