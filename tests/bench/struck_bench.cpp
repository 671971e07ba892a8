// What strikers and the acceleration click cost per sound, in processor time. Prints the
// figures of docs/sound/strikes.md and click.md.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "../synth/curved_bodies.hpp"
#include "synth/contact/acceleration_click.hpp"
#include "synth/contact/noise_burst.hpp"
#include "synth/contact/striker.hpp"

namespace carillon::synth {
namespace {

constexpr double audio_rate = 44100;

/// Processor seconds of one call, the least of seven rounds.
template <class Work>
double seconds(int calls, const Work& work) {
  double minimum = 1e9;
  for (int round = 0; round < 7; ++round) {
    const std::clock_t start = std::clock();
    for (int k = 0; k < calls; ++k) work(k);
    minimum = std::min(minimum, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / calls);
  }
  return minimum;
}

void strikers() {
  const contact::StruckBody body{0.3, 7e10, 0.2, 0};
  double sum = 0;
  for (const contact::Striker& striker : contact::preset_strikers()) {
    const contact::HertzContact contact = contact::hertz_contact(striker, body, 1);
    fmt::print("{:8} on 0.3 kg of 70 GPa at 1 m/s: {:8.3f} ms, {:.4f} N s, {:.1f} N\n",
               striker.name, 1e3 * contact.duration, contact.impulse, contact.peak_force);
    sum += contact.duration;
  }
  fmt::print("hertz_contact       {:9.3f} us\n",
             1e6 * seconds(100000, [&](int k) {
               sum += contact::hertz_contact(contact::preset_strikers()[0], body, 1 + k).duration;
             }));
  for (const double hardness : {0.0, 0.9}) {
    fmt::print("noise_burst {:.1f}     {:9.3f} us\n", hardness,
               1e6 * seconds(500, [&](int k) {
                 core::RandomStream random(0, static_cast<std::uint64_t>(k), "bench");
                 sum += contact::noise_burst({hardness, 0.1}, audio_rate, random).samples[1];
               }));
  }
  if (std::isnan(sum)) fmt::print("nan\n");  // keeps the work
}

void clicks() {
  const auto surface = curved_sphere(0.05, {0, 0, 0}, 10, 3);
  fmt::print("rigid_source, {} faces: {:.3f} ms, once for a body\n", surface.faces.size() / 10,
             1e3 * seconds(1, [&](int) { contact::rigid_source(surface, 1); }));
  for (const double radius : {0.005, 0.05, 0.5}) {
    const contact::RigidSource source{Vec3::Zero(), Eigen::Matrix3d::Identity(),
                                      Vec3::Constant(radius), 1};
    core::RandomStream random(0, 0, "bench");
    for (const modal::ContactForce& force :
         {modal::ContactForce{3e-4, {}}, contact::noise_burst({0.9, 0.1}, audio_rate, random)}) {
      const auto make = [&](int) {
        contact::acceleration_click(source, {0.1, 0.2, 0.3}, force, {1, 1, 1}, audio_rate, 44100);
      };
      fmt::print("click, radius {:.3f} m, {:5}: {:8.1f} us\n", radius,
                 force.samples.empty() ? "pulse" : "burst", 1e6 * seconds(100, make));
    }
  }
}

}  // namespace
}  // namespace carillon::synth

int main() {
  carillon::synth::strikers();
  carillon::synth::clicks();
}
