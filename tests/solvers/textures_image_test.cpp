#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "core/error.hpp"
#include "core/image_samples.hpp"
#include "core/temporary_folder.hpp"
#include "render/maps/generated_maps.hpp"
#include "render/maps/map_image.hpp"

namespace carillon::solvers {
namespace {

/// 4 x 4 pixels of one colour.
core::ImageSamples plain(int bits, const std::vector<std::uint16_t>& color) {
  core::ImageSamples image{4, 4, static_cast<int>(color.size()), bits, {}};
  for (int i = 0; i < 16; ++i) {
    image.values.insert(image.values.end(), color.begin(), color.end());
  }
  return image;
}

std::string message_of(const std::filesystem::path& path, const render::maps::MapImage& image) {
  try {
    render::maps::read_map(path, image);
  } catch (const core::Error& error) {
    return error.what();
  }
  return "nothing thrown";
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(MapImage, EightBitsAreCountedFrom128) {
  const core::TemporaryFolder folder;
  const auto path = folder.path() / "a.png";
  core::ImageSamples image = plain(8, {128, 128, 255});
  // The upper left pixel leans to the right and up: the surface falls there that way.
  image.values[0] = 192;
  image.values[1] = 160;
  image.values[2] = 192;
  core::write_png_samples(path, image);
  const render::maps::SurfaceMap map =
      render::maps::read_map(path, {.width = 0.02, .repeats = false});
  EXPECT_FALSE(map.relief());
  EXPECT_FALSE(map.repeats);
  EXPECT_EQ(map.name, "a");
  EXPECT_DOUBLE_EQ(map.texel, 0.005);
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(map.slopes_u[i], i == 12 ? -1.0F : 0.0F) << i;
    EXPECT_EQ(map.slopes_v[i], i == 12 ? -0.5F : 0.0F) << i;
  }
  const render::maps::SurfaceMap down =
      render::maps::read_map(path, {.width = 0.02, .green_down = true});
  EXPECT_EQ(down.slopes_v[12], 0.5F);
  EXPECT_EQ(down.slopes_u[12], -1.0F);
}

TEST(MapImage, AlphaIsHowFarItIsCutIn) {
  const core::TemporaryFolder folder;
  const auto path = folder.path() / "a.png";
  for (const int bits : {8, 16}) {
    const int full = bits == 8 ? 255 : 65535;
    core::ImageSamples image = plain(bits, {128, 128, 255, 0});
    image.values[3] = static_cast<std::uint16_t>(full);               // upper left
    image.values[4 * 15 + 3] = static_cast<std::uint16_t>(full / 5);  // lower right
    core::write_png_samples(path, image);
    const render::maps::SurfaceMap map = render::maps::read_map(path, {.width = 1, .depth = 0.25});
    ASSERT_TRUE(map.relief());
    EXPECT_EQ(map.heights[12], -0.25F);
    EXPECT_EQ(map.heights[3], -0.05F);
    EXPECT_EQ(map.heights[5], 0.0F);
    // Without a depth the same file is a normal map.
    EXPECT_EQ(bits == 8 && render::maps::read_map(path, {.width = 1}).relief(), false);
  }
}

TEST(MapImage, ComesBackAsItWasWritten) {
  const core::TemporaryFolder folder;
  const auto path = folder.path() / "a.png";
  for (const auto& generated : render::maps::generated_maps()) {
    render::maps::SurfaceMap map = render::maps::generate_map(generated.name, {}, 128, 1);
    const double depth = -*std::min_element(map.heights.begin(), map.heights.end());
    const render::maps::SurfaceMap back =
        render::maps::read_map(path, render::maps::write_map(path, map));
    ASSERT_EQ(back.heights.size(), map.heights.size());
    EXPECT_EQ(back.width, map.width);
    EXPECT_DOUBLE_EQ(back.texel, map.texel);
    for (std::size_t i = 0; i < map.heights.size(); ++i) {
      EXPECT_NEAR(back.heights[i], map.heights[i], depth / 65535);
    }
    map = render::maps::normal_map_of(map);
    map.repeats = false;
    const render::maps::SurfaceMap normals =
        render::maps::read_map(path, render::maps::write_map(path, map));
    EXPECT_FALSE(normals.repeats);
    ASSERT_EQ(normals.slopes_u.size(), map.slopes_u.size());
    for (std::size_t i = 0; i < map.slopes_u.size(); ++i) {
      const Vec3 a = render::maps::normal_of({normals.slopes_u[i], normals.slopes_v[i]});
      const Vec3 b = render::maps::normal_of({map.slopes_u[i], map.slopes_v[i]});
      EXPECT_LT((a - b).norm(), 4e-5);
    }
  }
  const render::maps::SurfaceMap flat{"flat", 4, 5, 0.1, true, std::vector<float>(20), {}, {}};
  EXPECT_EQ(render::maps::read_map(path, render::maps::write_map(path, flat)).heights,
            flat.heights);
}

TEST(MapImage, RefusesWithARemedy) {
  const core::TemporaryFolder folder;
  const auto path = folder.path() / "a.png";
  EXPECT_TRUE(has(message_of(path, {.width = 1}), "a.png: no such file"));
  EXPECT_TRUE(has(message_of(folder.path(), {.width = 1}), "cannot be read"));
  std::ofstream(path) << "no picture";
  EXPECT_TRUE(has(message_of(path, {.width = 1}), "as PNG"));
  core::write_png_samples(path, plain(8, {100}));
  EXPECT_TRUE(has(message_of(path, {.width = 1}), "grey"));
  core::write_png_samples(path, plain(8, {128, 128, 255}));
  EXPECT_TRUE(has(message_of(path, {.width = 1, .depth = 0.1}), "no alpha"));
  EXPECT_TRUE(has(message_of(path, {.width = 0}), "width must be positive"));
  EXPECT_TRUE(has(message_of(path, {.width = NAN}), "width must be positive"));
  EXPECT_TRUE(has(message_of(path, {.width = 1, .depth = -1}), "depth must be positive"));
  EXPECT_EQ(message_of(path, {.width = 1}), "nothing thrown");
  core::ImageSamples inward = plain(8, {128, 128, 255});
  inward.values[3 * 6 + 2] = 128;
  core::write_png_samples(path, inward);
  EXPECT_TRUE(has(message_of(path, {.width = 1}), "pixel (2, 1)"));
  inward.width = 8;
  inward.height = 2;
  core::write_png_samples(path, inward);
  EXPECT_TRUE(has(message_of(path, {.width = 1}), "too small"));
  const render::maps::SurfaceMap map = render::maps::generate_map("pebbles", {}, 64, 0);
  EXPECT_THROW(render::maps::write_map(folder.path() / "absent" / "a.png", map), core::FileError);
}

TEST(MapImage, BrokenFilesGiveAMapOrAnError) {
  const core::TemporaryFolder folder;
  const auto path = folder.path() / "a.png";
  const render::maps::MapImage image =
      render::maps::write_map(path, render::maps::generate_map("noise", {}, 24, 1));
  std::ifstream file(path, std::ios::binary);
  const std::string good{std::istreambuf_iterator<char>(file), {}};
  EXPECT_TRUE(rc::check([&] {
    std::string bytes = good.substr(0, *rc::gen::inRange<std::size_t>(0, good.size() + 1));
    for (int i = *rc::gen::inRange(0, 6); i > 0 && !bytes.empty(); --i) {
      // Headers are at the front.
      const std::size_t maximum =
          *rc::gen::arbitrary<bool>() ? std::min<std::size_t>(bytes.size(), 48) : bytes.size();
      bytes[*rc::gen::inRange<std::size_t>(0, maximum)] =
          static_cast<char>(*rc::gen::inRange(0, 256));
    }
    std::ofstream(path, std::ios::binary) << bytes;
    try {
      const render::maps::SurfaceMap map = render::maps::read_map(path, image);
      RC_ASSERT(map.heights.size() == std::size_t(map.width) * std::size_t(map.height));
    } catch (const core::Error& error) {
      RC_ASSERT(!error.message().empty());
    }
  }));
}

}  // namespace
}  // namespace carillon::solvers
