#include "core/image_samples.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include "core/error.hpp"
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
