#include "tests/render/offscreen_pictures.hpp"

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "core/child_process.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::render {
namespace {

TEST(Offscreen, NothingIsOfOsmesa) {
  ASSERT_EQ(offscreen(), "egl");
  std::ifstream file("/proc/self/maps");
  const std::string libraries(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(libraries.find("libOpenGL"), std::string::npos);
  EXPECT_EQ(libraries.find("libOSMesa"), std::string::npos);
}

TEST(Offscreen, EglDrawsWhatOsmesaDraws) {
  const core::TemporaryFolder folder;
  const auto path = folder / "pixels";
  const auto end = core::run_child(CARILLON_OTHER_PICTURES, {path.string()}, 120);
  ASSERT_EQ(end.code, 0) << end.output;
  const std::string others = core::read_file(path);
  std::size_t at = 0;
  for (const core::Image& picture : offscreen_pictures()) {
    ASSERT_LE(at + picture.pixels.size(), others.size());
    int greatest = 0;
    double sum = 0;
    for (const std::uint8_t own : picture.pixels) {
      const int difference = std::abs(own - static_cast<std::uint8_t>(others[at++]));
      greatest = std::max(greatest, difference);
      sum += difference;
    }
    RecordProperty("greatest_difference", greatest);
    // The same llvmpipe behind both; another version of one may round otherwise along edges.
    EXPECT_LE(greatest, 8);
    EXPECT_LE(sum / static_cast<double>(picture.pixels.size()), 0.02);
  }
  EXPECT_EQ(at, others.size());
}

}  // namespace
}  // namespace carillon::render
