#pragma once

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/motion/simulate.hpp"

namespace carillon::synth {

/// A box about the origin of its coordinates, of glass unless it is told otherwise.
inline motion::MovingBody box_body(const Vec3& sides, double density = 2500) {
  motion::MovingBody body;
  body.name = "box";
  body.rigid.mass = density * sides.prod();
  const Vec3 squares = sides.cwiseProduct(sides);
  body.rigid.inertia = body.rigid.mass / 12 * (Vec3::Constant(squares.sum()) - squares);
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) {
    corners.emplace_back((k & 1 ? 0.5 : -0.5) * sides.x(), (k & 2 ? 0.5 : -0.5) * sides.y(),
                         (k & 4 ? 0.5 : -0.5) * sides.z());
  }
  body.hulls.push_back(corners);
  body.youngs_modulus = 7e10;
  body.poisson_ratio = 0.2;
  body.curvature = 1000;
  return body;
}

inline motion::MovingBody ball_body(double radius, double density = 2500) {
  motion::MovingBody body;
  body.name = "ball";
  body.ball_radius = radius;
  body.rigid.mass = 4.0 / 3 * std::numbers::pi * density * radius * radius * radius;
  body.rigid.inertia = Vec3::Constant(0.4 * body.rigid.mass * radius * radius);
  body.youngs_modulus = 7e10;
  body.poisson_ratio = 0.2;
  body.curvature = 1 / radius;
  return body;
}

/// A fixed slab whose upper face is z = 0.
inline motion::MovingBody floor_body(double side = 4) {
  motion::MovingBody body = box_body({side, side, 0.1});
  body.name = "floor";
  body.fixed = true;
  body.start.pose.origin = {0, 0, -0.05};
  return body;
}

/// A relief cut as deep all over [m].
inline render::maps::SurfaceMap flat_relief(double depth) {
  render::maps::SurfaceMap map;
  map.name = "flat";
  map.width = map.height = 16;
  map.texel = 1e-3;
  map.heights.assign(256, static_cast<float>(-depth));
  return map;
}

/// A floor, its upper face textured all over.
inline motion::MovingBody textured_floor(const render::maps::SurfaceMap& map, double side = 4) {
  motion::MovingBody body = floor_body(side);
  render::maps::TexturedFace face;
  face.map = std::make_shared<const render::maps::SurfaceMap>(map);
  face.origin = {-side / 2, -side / 2, 0.05};
  face.size = {side, side};
  body.texture = face;
  return body;
}

inline motion::MovingBody at(motion::MovingBody body, const Vec3& place) {
  body.start.pose.origin = place;
  return body;
}

inline void set_surfaces(std::vector<motion::MovingBody>& bodies, double friction,
                         double restitution) {
  for (motion::MovingBody& body : bodies) {
    body.friction = friction;
    body.restitution = restitution;
  }
}

/// Largest energy above that of the start, over the largest kinetic energy there could be: that of
/// the start above the lowest that was met.
inline double energy_growth(const motion::Motion& motion) {
  const double start = motion.energy.front();
  double highest = start, lowest = start;
  for (const double energy : motion.energy) {
    highest = std::max(highest, energy);
    lowest = std::min(lowest, energy);
  }
  return start > lowest ? (highest - start) / (start - lowest) : highest - start;
}

}  // namespace carillon::synth
