#include "scene/blow.hpp"

#include <algorithm>
#include <limits>

namespace carillon::scene {

std::vector<synth::modal::SurfacePoint> spread_points(const synth::modal::SurfaceSampler& sampler,
                                                      const solvers::modes::ModeSurface& surface,
                                                      std::size_t count,
                                                      core::RandomStream& places) {
  constexpr std::size_t drawn_for_each = 64;
  std::vector<synth::modal::SurfacePoint> drawn(drawn_for_each * count);
  std::vector<Vec3> positions;
  for (synth::modal::SurfacePoint& point : drawn) {
    point = sampler.sample(places);
    positions.push_back(synth::modal::frame_at(surface, point).position);
  }
  std::vector<double> distances(drawn.size(), std::numeric_limits<double>::infinity());
  std::vector<synth::modal::SurfacePoint> chosen;
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

}  // namespace carillon::scene
