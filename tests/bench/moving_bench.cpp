// What the sound of moving bodies costs: `carillon-bench-moving`.
#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <numbers>
#include <tuple>

#include "render/maps/generated_maps.hpp"
#include "synth/motion/detail/driven_modes.hpp"
#include "synth/motion/detail/relief_contacts.hpp"
#include "synth/motion/motion_sound.hpp"
#include "synth/radiation/equivalent_sources.hpp"
#include "synth/touch/stylus.hpp"
#include "tests/synth/radiators.hpp"
#include "tests/synth/random_rings.hpp"
#include "tests/synth/scraped_face.hpp"

namespace carillon::synth {
namespace {

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void radiation_of_poses() {
  constexpr double fixed_radius = 0.05;
  constexpr int mode_count = 50, poses = 100;
  std::vector<double> ka;
  for (int i = 0; i < mode_count; ++i) ka.push_back(0.5 + 0.3 * i);
  const auto modes =
      sphere_modes(curved_sphere(fixed_radius, Vec3::Zero(), 4, 3), fixed_radius, 2, ka);
  radiation::EquivalentSources fit;
  const double fitted = seconds_of([&] { fit = radiation::fit_equivalent_sources(modes); });
  const radiation::SourceField field(fit);
  std::vector<modal::Listener> listeners;
  for (int i = 0; i < poses; ++i) listeners.push_back({{0.3, 0.4 + 0.01 * i, 0.8}});
  const double heard = seconds_of([&] { field.pressure_at(listeners); });
  fmt::print("radiation: {} modes, {} layers, {} points: fit {:.3f} s, a listener {:.3f} ms\n",
             mode_count, fit.layers, fit.points.size(), fitted, 1e3 * heard / poses);
}

/// One second of modes that ring, and that a force at a moving place drives, in blocks of 1 ms.
void driven_modes() {
  constexpr double audio_rate = 44100;
  constexpr Eigen::Index block_size = 44;
  for (const int count : {20, 60, 300}) {
    modal::RingDown rings = random_rings(count, 3, false);
    for (double& rate : rings.decay_rates) rate = 0.5;
    modal::Readout other = rings.readout;
    other.velocity *= 0.9;
    Eigen::MatrixX3d from = Eigen::MatrixX3d::Ones(count, 3);
    const motion::Drive drive = {from, 0.9 * from, Eigen::Matrix3Xd::Ones(3, block_size + 1)};
    const auto rate = [&](bool driven, bool moving) {
      motion::DrivenModes modes(rings.eigenvalues, rings.decay_rates, audio_rate);
      modes.strike(rings.excitation, {1e-3}, 0);
      Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(block_size, 1);
      const motion::DrivenGains gains = {&rings.readout, moving ? &other : &rings.readout, 0, 1};
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

/// A second of a contact that scrapes.
void lasting_forces() {
  const Scrape scrape(sine_map(2e-3, 1e-6, 32, 16), 0.3, 5, 1);
  for (const auto& [name, roughness, excitation] :
       {std::tuple("map", 0.0, motion::ContactExcitation::height_profile),
        std::tuple("map and roughness", 0.05, motion::ContactExcitation::height_profile),
        std::tuple("texel impulses", 0.0, motion::ContactExcitation::texel_impulses),
        std::tuple("solver impulses", 0.0, motion::ContactExcitation::solver_impulses)}) {
    motion::LastingForceOptions options;
    options.roughness = roughness;
    options.excitation = excitation;
    motion::LastingForces forces(scrape.motion, scrape.bodies, options);
    forces.force(0);  // traces the face
    fmt::print("force of a contact that lasts 1 s, {}: {:.1f} ms\n", name,
               1e3 * seconds_of([&] { forces.force(0); }));
  }
}

/// A body that is scraped, struck, flies past or rests: where the time goes.
void whole_sounds() {
  std::vector<double> ka;
  for (int i = 0; i < 60; ++i) ka.push_back(0.5 + 0.3 * i);
  const auto modes = sphere_modes(curved_sphere(0.05, Vec3::Zero(), 4, 3), 0.05, 2, ka);
  const radiation::SourceField field(radiation::fit_equivalent_sources(modes));
  motion::SoundingBody body;
  body.modes = &modes;
  body.field = &field;
  body.decay_rates.assign(modes.size(), 10);
  body.rests = support::parse_support("table");
  body.click = contact::rigid_source(modes.surface, 0.3);
  const std::vector<modal::Listener> listeners = {{{1, 0.5, 0.8}}};
  const auto report = [&](const char* name, const Scrape& scene,
                          const std::vector<motion::SoundingBody>& bodies) {
    motion::MotionSound sound;
    const double whole = seconds_of(
        [&] { sound = motion::motion_sound(scene.motion, scene.bodies, bodies, listeners, {}); });
    const auto part = [](const motion::EffectUse& use) {
      return fmt::format("{:.0f} ({})", 1e3 * use.seconds, use.calls);
    };
    fmt::print(
        "{}: {:.0f} ms; impacts {}, contacts {}, damping {}, clicks {}, radiation {}, "
        "ringing {}\n",
        name, 1e3 * whole, part(sound.impacts), part(sound.lasting_contacts),
        part(sound.contact_damping), part(sound.clicks), part(sound.moving_radiation),
        part(sound.ringing));
  };
  const Scrape scrape(sine_map(2e-3, 1e-6, 32, 16), 0.3, 5, 1);
  report("1 s scraped", scrape, {{}, body});
  Scrape still(sine_map(2e-3, 1e-6, 32, 16), 0, 5, 1);
  report("1 s at rest", still, {{}, body});
  Scrape struck = still;
  struck.motion.contacts.clear();
  for (int i = 0; i < 1000; ++i) {
    motion::Impact impact;
    impact.time = 1e-3 * (i + 0.3);
    impact.bodies = {0, 1};
    impact.points = {Vec3(0, 0, 0.05), Vec3(0, 0, 0.05)};
    impact.normal = Vec3::UnitZ();
    impact.impulse = Vec3(0, 0, 1e-3);
    impact.duration = 1e-4;
    struck.motion.impacts.push_back(impact);
  }
  report("1 s struck 1000 times", struck, {{}, body});
  for (std::size_t k = 0; k < struck.motion.states.size(); ++k) {
    const double time = 1e-3 * static_cast<double>(k);
    struck.motion.states[k][1].pose = {
        Eigen::Quaterniond(Eigen::AngleAxisd(20 * time, Vec3::UnitX())), Vec3(0, 0, -3 * time)};
  }
  report("the same, turning three times and flying", struck, {{}, body});
}

void stylus_ticks() {
  render::maps::TexturedFace face;
  face.map = std::make_shared<const render::maps::SurfaceMap>(sine_map(2e-3, 1e-5, 32, 16));
  face.size = {1, 1};
  const std::vector<Vec3> corners = {{0.1, 0.1, 0}, {0.6, 0.1, 0}};
  const std::vector<Vec3> hand = touch::drawn_path(corners, 0.1, 1000);
  for (const bool relief : {true, false}) {
    if (!relief)
      face.map =
          std::make_shared<const render::maps::SurfaceMap>(render::maps::normal_map_of(*face.map));
    const double seconds = seconds_of([&] { touch::draw_stylus(face, hand, {}, {}); });
    fmt::print("stylus over a {}: {:.2f} us a tick\n", relief ? "relief" : "normal map",
               1e6 * seconds / static_cast<double>(hand.size()));
  }
}

/// A tile 0.1 mm deep in a map of its own size, flat and tilted by one degree.
void relief_contacts() {
  const std::vector<solvers::mesh::Triangle> bottom = {{0, 2, 1}, {1, 2, 3}};  // seen from below
  for (const char* name : {"brick", "pebbles"}) {
    for (const int texels : {256, 512, 1024}) {
      const auto map = std::make_shared<const render::maps::SurfaceMap>(
          render::maps::generate_map(name, {}, texels, 1));
      const double side = 0.16;  // of 0.45 m of bricks, 0.16 m of pebbles
      std::optional<motion::ReliefPeaks> peaks;
      const double prepared = seconds_of([&] { peaks.emplace(map); });
      fmt::print("tile of 0.16 m on {} of {}^2 texels: prepared in {:.1f} ms", name, texels,
                 1e3 * prepared);
      for (const double tilt : {0.0, 1.0}) {
        const Eigen::AngleAxisd turn(tilt * std::numbers::pi / 180, Vec3(1, 2, 0).normalized());
        std::vector<Vec3> corners;
        double lowest = 0;
        for (int k = 0; k < 4; ++k) {
          corners.push_back(
              turn * Vec3(k % 2 == 0 ? -side / 2 : side / 2, k < 2 ? -side / 2 : side / 2, 0));
          lowest = std::min(lowest, corners.back().z());
        }
        for (Vec3& p : corners) p += Vec3(side / 2, side / 2, -1e-4 - lowest);
        constexpr int calls = 20;
        const double seconds = seconds_of([&] {
          for (int k = 0; k < calls; ++k)
            motion::hull_on_relief(*peaks, {side, side}, corners, bottom);
        });
        fmt::print(", {} {:.2f} ms", tilt > 0 ? "tilted" : "flat", 1e3 * seconds / calls);
      }
      fmt::print("\n");
    }
  }
}

}  // namespace
}  // namespace carillon::synth

int main() {
  carillon::synth::radiation_of_poses();
  carillon::synth::driven_modes();
  carillon::synth::lasting_forces();
  carillon::synth::whole_sounds();
  carillon::synth::stylus_ticks();
  carillon::synth::relief_contacts();
}
