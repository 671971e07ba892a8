#include "synth/motion/detail/contact_way.hpp"

#include <algorithm>

#include "synth/motion/detail/collision_shape.hpp"

namespace carillon::synth::motion {

namespace {

/// A place of contact goes at most so many times as fast as the bodies slide and turn.
constexpr double fastest = 1.25;
constexpr std::size_t easing_steps =
    5;  ///< steps to both sides over which such a way starts and stops

/// Means over a triangle of steps, as wide as there are steps to both sides: an even way stays.
std::vector<Vec3> eased(const std::vector<Vec3>& points) {
  std::vector<Vec3> result;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const std::size_t wide = std::min({easing_steps, k, points.size() - 1 - k});
    Vec3 off = Vec3::Zero();
    double sum = static_cast<double>(wide) + 1;
    for (std::size_t j = 1; j <= wide; ++j) {
      const double weight = static_cast<double>(wide + 1 - j);
      off += weight * ((points[k - j] - points[k]) + (points[k + j] - points[k]));
      sum += 2 * weight;
    }
    result.push_back(points[k] + off / sum);
  }
  return result;
}

/// What collides as hulls touches with corners and edges.
bool has_corners(const MovingBody& body) {
  return !(body.ball_radius > 0) && !body.hulls.empty();
}

}  // namespace

std::vector<Vec3> contact_way(const Motion& motion, std::span<const MovingBody> bodies,
                              const LastingContact& contact, std::size_t side) {
  const std::size_t body = contact.bodies[side], other = contact.bodies[1 - side];
  const bool hops = has_corners(bodies[body]) && has_corners(bodies[other]);
  const double reach = hops ? std::min(reach_of(bodies[body]), reach_of(bodies[other])) : 0;
  std::vector<Vec3> points;
  for (std::size_t k = 0; k < contact.steps.size(); ++k) {
    const ContactStep& step = contact.steps[k];
    points.push_back(step.points[side]);
    const std::size_t state = std::min(contact.first_step + k, motion.states.size() - 1);
    const std::vector<BodyState>& states = motion.states[state];
    if (k > 0 && hops) {
      const double turning = (states[body].spin - states[other].spin).norm() * reach;
      const double longest = fastest * (step.slip.norm() + turning) * motion.step;
      const Vec3 normal = states[body].pose.turn.conjugate() * step.normal;
      const Vec3 way = points[k] - points[k - 1];
      const Vec3 along = way - normal.dot(way) * normal;  // heights are the relief's own
      if (along.norm() > longest) points[k] -= (1 - longest / along.norm()) * along;
    }
    if (!bodies[body].texture || !(bodies[other].ball_radius > 0)) continue;
    const Vec3 normal = bodies[body].texture->normal();
    const Vec3 centre =
        states[body].pose.to_body(states[other].pose.to_world(bodies[other].rigid.centre));
    points.back() = centre + normal.dot(points.back() - centre) * normal;
  }
  return hops ? eased(points) : points;
}

}  // namespace carillon::synth::motion
