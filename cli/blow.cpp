#include "cli/blow.hpp"

#include <algorithm>
#include <limits>

namespace carillon::cli {

std::vector<synth::SurfacePoint> spread_points(const synth::SurfaceSampler& sampler,
                                               const solvers::ModeSurface& surface,
                                               std::size_t count, core::RandomStream& places) {
  constexpr std::size_t drawn_for_each = 64;
  std::vector<synth::SurfacePoint> drawn(drawn_for_each * count);
  std::vector<Vec3> positions;
  for (synth::SurfacePoint& point : drawn) {
    point = sampler.sample(places);
    positions.push_back(synth::frame_at(surface, point).position);
  }
  std::vector<double> distances(drawn.size(), std::numeric_limits<double>::infinity());
  std::vector<synth::SurfacePoint> chosen;
  std::size_t next = 0;
  while (chosen.size() < count) {
    chosen.push_back(drawn[next]);
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      distances[i] = std::min(distances[i], (positions[i] - positions[next]).norm());
    }
    next = std::size_t(std::max_element(distances.begin(), distances.end()) - distances.begin());
  }
  return chosen;
}

}  // namespace carillon::cli
