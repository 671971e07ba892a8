#pragma once

#include "render/maps/surface_map.hpp"
#include "tests/synth/hand_made_motion.hpp"

namespace carillon::synth {

/// A sine along u of a wavelength and an amplitude [m], `texels` a wave, as heights of texels.
inline render::maps::SurfaceMap sine_map(double wavelength, double amplitude, int texels,
                                         int waves) {
  render::maps::SurfaceMap map;
  map.width = texels * waves;
  map.height = 8;
  map.texel = wavelength / texels;
  for (int j = 0; j < map.height; ++j) {
    for (int i = 0; i < map.width; ++i) {
      const double phase = 2 * M_PI * (i + 0.5) / texels;
      map.heights.push_back(static_cast<float>(amplitude * (std::sin(phase) - 1)));
    }
  }
  return map;
}

/// A relief of one step from 0 down to -depth at x = 32 texels.
inline render::maps::SurfaceMap step_map(double texel, double depth) {
  render::maps::SurfaceMap map;
  map.width = 64;
  map.height = 4;
  map.texel = texel;
  map.repeats = false;
  for (int j = 0; j < map.height; ++j) {
    for (int i = 0; i < map.width; ++i) {
      map.heights.push_back(i < 32 ? 0.0F : static_cast<float>(-depth));
    }
  }
  return map;
}

/// A tip (body 0) that is drawn over the textured face z = 0 of a body that is held (body 1), along
/// x from x = 0.01 m on.
struct Scrape {
  motion::Motion motion;
  std::vector<motion::MovingBody> bodies{2};

  Scrape(const render::maps::SurfaceMap& map, double speed, double force, double seconds,
         double step = 1e-3) {
    bodies[0].rigid.mass = 0.1;
    bodies[1].fixed = true;
    bodies[1].texture.emplace();
    bodies[1].texture->map = std::make_shared<const render::maps::SurfaceMap>(map);
    bodies[1].texture->size = {10, 10};
    const auto at = [=](double time) { return Vec3(0.01 + speed * time, 5, 0); };
    motion = hand_made_motion(seconds, step, 2, [&](std::size_t body, double time) {
      return motion::Pose{Eigen::Quaterniond::Identity(),
                          body == 0 ? at(time) : Vec3(Vec3::Zero())};
    });
    motion::LastingContact contact;
    contact.bodies = {0, 1};
    for (std::size_t k = 0; k + 1 < motion.states.size(); ++k) {
      motion::ContactStep now;
      now.points = {Vec3(Vec3::Zero()), at(static_cast<double>(k) * step)};
      now.normal = Vec3::UnitZ();
      now.force = Vec3(0, 0, force);
      now.slip = Vec3(speed, 0, 0);
      now.sweep = {Vec3(Vec3::Zero()), now.slip};
      contact.steps.push_back(now);
    }
    motion.contacts.push_back(contact);
  }
};

}  // namespace carillon::synth
