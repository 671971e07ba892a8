#include "synth/touch/stylus.hpp"

#include <limits>

namespace carillon::synth::touch {

motion::Motion motion_of(const Touch& touch, const render::maps::TexturedFace& face) {
  motion::Motion motion;
  motion.step = 1 / touch.rate;
  motion.left.assign(2, std::numeric_limits<double>::infinity());
  const Vec3 normal = face.normal();
  const std::size_t ticks = touch.tip.size();
  const auto velocity = [&](std::size_t tick) -> Vec3 {
    if (tick + 1 >= ticks) return Vec3::Zero();
    return (touch.tip[tick + 1] - touch.tip[tick]) * touch.rate;
  };
  bool touching = false;
  for (std::size_t tick = 0; tick < ticks; ++tick) {
    std::vector<motion::BodyState> states(2);
    states[0].pose.origin = touch.tip[tick];
    states[0].velocity = velocity(tick);
    motion.states.push_back(std::move(states));
    if (tick + 1 == ticks) break;
    const double push = touch.forces[tick].dot(normal);
    if (!(push > 0)) {
      touching = false;
      continue;
    }
    if (!touching) {
      motion::LastingContact contact;
      contact.bodies = {0, 1};
      contact.first_step = tick;
      motion.contacts.push_back(contact);
    }
    touching = true;
    motion::ContactStep step;
    step.points = {Vec3(Vec3::Zero()), touch.tip[tick]};
    step.normal = normal;
    step.force = touch.forces[tick];
    step.slip = velocity(tick) - velocity(tick).dot(normal) * normal;
    step.sweep = {Vec3(Vec3::Zero()), step.slip};
    motion.contacts.back().steps.push_back(step);
  }
  return motion;
}

motion::MovingBody moving_stylus(const Stylus& stylus) {
  motion::MovingBody body;
  body.name = "stylus";
  body.rigid.mass = stylus.mass;
  body.ball_radius = stylus.radius;
  body.friction = stylus.friction;
  return body;
}

}  // namespace carillon::synth::touch
