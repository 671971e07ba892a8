// What the sound of moving bodies costs: `carillon-bench-moving`.
#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <functional>

#include "synth/equivalent_sources.hpp"
#include "tests/synth/radiators.hpp"

namespace carillon::synth {
namespace {

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void radiation_of_poses() {
  constexpr double kRadius = 0.05;
  constexpr int kModes = 50, kPoses = 100;
  std::vector<double> ka;
  for (int i = 0; i < kModes; ++i) ka.push_back(0.5 + 0.3 * i);
  const auto modes = sphere_modes(curved_sphere(kRadius, Vec3::Zero(), 4, 3), kRadius, 2, ka);
  EquivalentSources fit;
  const double fitted = seconds_of([&] { fit = fit_equivalent_sources(modes); });
  const SourceField field(fit);
  std::vector<Listener> listeners;
  for (int i = 0; i < kPoses; ++i) listeners.push_back({{0.3, 0.4 + 0.01 * i, 0.8}});
  const double heard = seconds_of([&] { field.pressure_at(listeners); });
  fmt::print("radiation: {} modes, {} layers, {} points: fit {:.3f} s, a listener {:.3f} ms\n",
             kModes, fit.layers, fit.points.size(), fitted, 1e3 * heard / kPoses);
}

}  // namespace
}  // namespace carillon::synth

int main() {
  carillon::synth::radiation_of_poses();
}
