// A bowl and a block in twelve materials, six to a row: docs/appearances.png.
// usage: carillon-material-pictures FILE.png [MATERIAL ...]
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>

#include "render/frame.hpp"
#include "tests/render/bodies.hpp"

namespace carillon::bench {
namespace {

constexpr int side = 160, columns = 6;

void paste(const core::Image& picture, int column, int row, core::Image& sheet) {
  for (int y = 0; y < side; ++y) {
    std::copy_n(picture.pixels.begin() + std::ptrdiff_t{3} * y * side, 3 * side,
                sheet.pixels.begin() +
                    std::ptrdiff_t{3} * ((row * side + y) * sheet.width + column * side));
  }
}

void run(const char* file, const std::vector<std::string>& materials) {
  const solvers::mesh::SurfaceMesh bowl = render::bowl(0.08, 0.008, 128);
  const solvers::mesh::SurfaceMesh block = render::box({-0.1, -0.05, -0.035}, {0.1, 0.05, 0.035});
  const int rows = 2 * static_cast<int>((materials.size() + columns - 1) / columns);
  core::Image sheet{columns * side, rows * side, 3, {}};
  sheet.pixels.resize(std::size_t(3) * std::size_t(sheet.width) * std::size_t(sheet.height), 255);
  const render::Camera camera{.width = side, .height = side};
  for (std::size_t i = 0; i < materials.size(); ++i) {
    render::Appearance look = render::appearance_of(materials[i]);
    const int column = static_cast<int>(i) % columns, row = 2 * (static_cast<int>(i) / columns);
    look.piece = 2 * i;
    paste(render::render_frame(bowl, camera, look), column, row, sheet);
    look.piece = 2 * i + 1;
    paste(render::render_frame(block, camera, look), column, row + 1, sheet);
  }
  write_png(file, sheet);
}

}  // namespace
}  // namespace carillon::bench

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: {} FILE.png [MATERIAL ...]\n", argv[0]);
    return 2;
  }
  std::vector<std::string> materials(argv + 2, argv + argc);
  if (materials.empty()) {
    materials = {"ceramic", "glass", "wood", "plastic", "iron",   "steel",
                 "copper",  "brass", "oak",  "granite", "marble", "polycarbonate"};
  }
  carillon::bench::run(argv[1], materials);
  return EXIT_SUCCESS;
}
