// Processor time of sampling, tracing and making maps. Prints the tables of docs/textures.md.
// With a folder, writes the generated maps there as PNG.
#include <fmt/core.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <limits>

#include "core/random.hpp"
#include "render/maps/generated_maps.hpp"
#include "render/maps/map_image.hpp"

namespace carillon::bench {
namespace {

using render::maps::SurfaceMap;

/// Least of some runs [s]: other programs do not count, nor do cold caches.
double seconds(int runs, const std::function<void()>& work) {
  double minimum = std::numeric_limits<double>::infinity();
  for (int run = 0; run < runs; ++run) {
    const std::clock_t begin = std::clock();
    work();
    minimum = std::min(minimum, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  return minimum;
}

void time_sampling(const SurfaceMap& relief) {
  constexpr int count = 200000;
  std::vector<Eigen::Vector2d> scattered, along;
  core::RandomStream random(1, 0, "bench");
  for (int i = 0; i < count; ++i) {
    scattered.emplace_back(random.uniform() * relief.size().x(),
                           random.uniform() * relief.size().y());
    along.emplace_back(1e-5 * i, 0.37e-5 * i);  // 0.5 m/s at 44.1 kHz
  }
  double kept = 0;  // so that nothing is optimised away
  const SurfaceMap normals = render::maps::normal_map_of(relief);
  const auto time = [&](const char* name, const auto& at, const SurfaceMap& map) {
    for (const auto* places : {&along, &scattered}) {
      const double minimum = seconds(5, [&] {
        for (const auto& uv : *places) kept += at(map, uv);
      });
      fmt::print("{:28} {:10} {:6.1f} ns\n", name, places == &along ? "on a path" : "scattered",
                 1e9 * minimum / count);
    }
  };
  const auto height = [](const auto& map, const auto& uv) { return height_at(map, uv); };
  const auto slope = [](const auto& map, const auto& uv) { return slope_at(map, uv).x(); };
  const auto detail = [](const auto& map, const auto& uv) {
    const auto found = detail_at(map, uv);
    return found.height + found.slope.x() + found.curvature(1, 1);
  };
  time("height of a relief", height, relief);
  time("slope of a relief", slope, relief);
  time("all of a relief", detail, relief);
  time("slope of a normal map", slope, normals);
  time("all of a normal map", detail, normals);
  fmt::print(stderr, "{}\n", kept);
}

void time_tracing(const SurfaceMap& relief) {
  for (const double texels : {0.5, 3.0, 10.0, 30.0, 100.0, 1000.0}) {
    const double radius = texels * relief.texel;
    const double map = seconds(1, [&] { render::maps::traced_map(relief, radius); });
    fmt::print("{:8} {:4} x {:4}, radius of {:6.1f} texels: {:7.3f} s\n", relief.name, relief.width,
               relief.height, texels, map);
  }
}

void run(const std::filesystem::path& folder) {
  for (const auto& generated : render::maps::generated_maps()) {
    SurfaceMap map;
    const double minimum =
        seconds(3, [&] { map = render::maps::generate_map(generated.name, {}, 512, 1); });
    fmt::print("{:28} {:4} x {:4} {:8.3f} s\n", generated.name, map.width, map.height, minimum);
    if (!folder.empty()) render::maps::write_map(folder / (generated.name + ".png"), map);
  }
  const SurfaceMap brick = render::maps::generate_map("brick", {}, 512, 1);
  const SurfaceMap noise = render::maps::generate_map("noise", {}, 512, 1);
  const SurfaceMap normals = render::maps::normal_map_of(noise);
  fmt::print("{:28} {:4} x {:4} {:8.3f} s\n", "integrated", normals.width, normals.height,
             seconds(3, [&] { render::maps::integrated_relief(normals); }));
  time_sampling(brick);
  time_tracing(brick);
  time_tracing(noise);
}

}  // namespace
}  // namespace carillon::bench

int main(int argc, char** argv) {
  carillon::bench::run(argc > 1 ? argv[1] : "");
  return EXIT_SUCCESS;
}
