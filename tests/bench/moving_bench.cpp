// What the sound of moving bodies costs: `carillon-bench-moving`.
#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <functional>

#include "synth/equivalent_sources.hpp"
#include "synth/motion/driven_modes.hpp"
#include "tests/synth/radiators.hpp"
#include "tests/synth/random_rings.hpp"

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

/// One second of modes that ring, and that a force at a moving place drives, in blocks of 1 ms.
void driven_modes() {
  constexpr double kRate = 44100;
  constexpr Eigen::Index kBlock = 44;
  for (const int count : {20, 60, 300}) {
    RingDown rings = random_rings(count, 3, false);
    for (double& rate : rings.decay_rates) rate = 0.5;
    Readout other = rings.readout;
    other.velocity *= 0.9;
    Eigen::MatrixX3d from = Eigen::MatrixX3d::Ones(count, 3);
    const Drive drive = {from, 0.9 * from, Eigen::Matrix3Xd::Ones(3, kBlock + 1)};
    const auto rate = [&](bool driven, bool moving) {
      DrivenModes modes(rings.eigenvalues, rings.decay_rates, kRate);
      modes.strike(rings.excitation, {1e-3}, 0);
      Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(kBlock, 1);
      const DrivenGains gains = {&rings.readout, moving ? &other : &rings.readout, 0, 1};
      const double seconds = seconds_of([&] {
        for (int block = 0; block < 5000; ++block) {
          if (driven) {
            modes.render({&drive, 1}, gains, rows);
          } else {
            modes.render({}, gains, rows);
          }
        }
      });
      return 1e-6 * static_cast<double>(modes.mode_samples()) / seconds;
    };
    fmt::print(
        "{:3} modes, million mode-samples per second: ringing {:.0f}, driven {:.0f}, "
        "driven with moving gains {:.0f}\n",
        count, rate(false, false), rate(true, false), rate(true, true));
  }
}

}  // namespace
}  // namespace carillon::synth

int main() {
  carillon::synth::radiation_of_poses();
  carillon::synth::driven_modes();
}
