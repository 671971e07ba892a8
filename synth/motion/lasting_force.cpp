#include "synth/motion/lasting_force.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/error.hpp"
#include "core/random.hpp"
#include "synth/motion/detail/contact_places.hpp"
#include "synth/motion/detail/contact_way.hpp"

namespace carillon::synth::motion {

namespace {

constexpr double fade_time = 5e-3;  ///< of a contact's begin and end [s]
constexpr double slow = 1e-3;     ///< what moves faster has its whole roughness and friction [m/s]
constexpr double at_rest = 1e-4;  ///< what creeps slower than this is at rest [m/s]
/// A map is averaged over so much of the way between two samples: waves of half the sample rate are
/// 42 dB weaker for it, those of an eighth 2 dB.
constexpr double apart = 1.5;
constexpr double texel_steps = 8;  ///< looks at the way per texel

/// A value of each step, between steps in straight lines; the last goes on.
template <class Value>
Value between(const std::vector<Value>& values, double place) {
  const double last = static_cast<double>(values.size() - 1);
  const double at = std::clamp(place, 0.0, last);
  const auto k = std::min(static_cast<std::size_t>(at), values.size() - 1);
  const std::size_t next = std::min(k + 1, values.size() - 1);
  return values[k] + (at - static_cast<double>(k)) * (values[next] - values[k]);
}

/// 0 at rest, 1 in motion.
double moving_fraction(double speed) {
  return std::clamp((speed - at_rest) / (slow - at_rest), 0.0, 1.0);
}

double contact_modulus(const MovingBody& a, const MovingBody& b) {
  if (!(a.youngs_modulus > 0 && b.youngs_modulus > 0)) return 0;
  return 1 / ((1 - a.poisson_ratio * a.poisson_ratio) / a.youngs_modulus +
              (1 - b.poisson_ratio * b.poisson_ratio) / b.youngs_modulus);
}

/// Share of the straight way between two places at which a texel's edge lies; the mean of two.
double edge_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double texel) {
  double sum = 0;
  int edges = 0;
  for (int axis = 0; axis < 2; ++axis) {
    const double a = std::floor(from[axis] / texel), b = std::floor(to[axis] / texel);
    if (a == b) continue;
    sum += (std::max(a, b) * texel - from[axis]) / (to[axis] - from[axis]);
    ++edges;
  }
  return edges > 0 ? sum / edges : 0.5;
}

double fade(double time, double length) {
  const double ramp = std::min(fade_time, length / 4);
  const double near = std::min(time, length - time);
  if (near >= ramp) return 1;
  return near <= 0 ? 0 : (1 - std::cos(std::numbers::pi * near / ramp)) / 2;
}

}  // namespace

/// One body's part in a contact.
struct LastingForces::Side {
  const TracedFace* face = nullptr;   ///< null: no map
  ContactPath path;                   ///< body's coordinates
  std::vector<Vec3> u, v, normal;     ///< of the face, world, of each step
  double sign = 1;                    ///< of a force on the other body as one on the first
  std::optional<FractalNoise> noise;  ///< along the normal, and across
};

LastingForces::LastingForces(const Motion& motion, std::span<const MovingBody> bodies,
                             const LastingForceOptions& options)
    : motion_(motion), bodies_(bodies), options_(options) {
  if (motion.states.empty() || motion.states.front().size() != bodies.size()) {
    throw core::InputError(fmt::format("lasting forces: {} bodies for a motion of {}",
                                       bodies.size(),
                                       motion.states.empty() ? 0 : motion.states.front().size()));
  }
  if (!(options.sample_rate > 0) || !(options.roughness >= 0) || !(options.edge_radius >= 0) ||
      !(options.smoothing >= 0)) {
    throw core::InputError(
        fmt::format("lasting forces: a roughness of {}, an edge of {} m or a window of {} s cannot "
                    "be",
                    options.roughness, options.edge_radius, options.smoothing));
  }
  if (!options_.traced) options_.traced = std::make_shared<TracedMaps>();
  using Pair = std::array<std::size_t, 2>;
  std::map<std::pair<Pair, std::size_t>, double> sums;
  for (const LastingContact& contact : motion.contacts) {
    normal_.push_back(smooth_normal_force(contact, motion.step, options.smoothing));
    for (std::size_t k = 0; k < contact.steps.size(); ++k) {
      sums[{contact.bodies, contact.first_step + k}] += normal_.back()[k];
    }
  }
  for (std::size_t c = 0; c < motion.contacts.size(); ++c) {
    const LastingContact& contact = motion.contacts[c];
    std::vector<double>& fractions = share_.emplace_back();
    for (std::size_t k = 0; k < contact.steps.size(); ++k) {
      const double sum = sums[{contact.bodies, contact.first_step + k}];
      fractions.push_back(sum > 0 ? normal_[c][k] / sum : 0);
    }
  }
}

double LastingForces::radius_of(std::size_t body) const {
  const MovingBody& moving = bodies_[body];
  if (moving.ball_radius > 0) return moving.ball_radius;
  return moving.curvature > 0 ? 1 / moving.curvature : options_.edge_radius;
}

double LastingForces::reduced_mass(const LastingContact& contact) const {
  double inverse = 0;
  for (const std::size_t body : contact.bodies) {
    if (!bodies_[body].fixed) inverse += 1 / bodies_[body].rigid.mass;
  }
  return inverse > 0 && std::isfinite(inverse) ? 1 / inverse : 0;
}

const TracedFace& LastingForces::face_of(std::size_t body, double radius) {
  const auto key = std::make_pair(body, radius);
  auto found = faces_.find(key);
  if (found == faces_.end()) {
    const render::maps::TexturedFace& texture = *bodies_[body].texture;
    found =
        faces_.emplace(key, TracedFace(texture, options_.traced->of(texture.map, radius))).first;
  }
  return found->second;
}

LastingForce LastingForces::silence(const LastingContact& contact) const {
  const double step = motion_.step * options_.sample_rate;
  const auto sample = [&](std::size_t k) {
    return static_cast<std::size_t>(std::ceil(static_cast<double>(k) * step));
  };
  LastingForce result;
  result.first_sample = sample(contact.first_step);
  const std::size_t end = sample(contact.first_step + contact.steps.size());
  result.force.setZero(3, static_cast<Eigen::Index>(end - result.first_sample));
  return result;
}

LastingForces::Side LastingForces::side_of(const LastingContact& contact, std::size_t side) {
  Side own = {.face = nullptr,
              .path = ContactPath(contact_way(motion_, bodies_, contact, side), motion_.step),
              .u = {},
              .v = {},
              .normal = {},
              .sign = side == 0 ? -1.0 : 1.0,
              .noise = {}};
  const std::size_t body = contact.bodies[side];
  const bool papers = options_.excitation == ContactExcitation::texel_impulses;
  if (bodies_[body].texture && (papers || options_.map)) {
    own.face = &face_of(body, papers ? 0 : radius_of(contact.bodies[1 - side]));
  }
  if (!papers && options_.roughness > 0) {
    const double longest =
        bodies_[body].texture ? bodies_[body].texture->map->texel : options_.longest;
    // A surface of its own for each body.
    own.noise.emplace(core::RandomStream(options_.seed, body, "roughness").next(), longest,
                      options_.exponent);
  }
  for (std::size_t k = 0; k <= contact.steps.size(); ++k) {
    const std::size_t state = std::min(contact.first_step + k, motion_.states.size() - 1);
    const Eigen::Quaterniond& turn = motion_.states[state][body].pose.turn;
    const Vec3 outward = -own.sign * -contact.steps[std::min(k, contact.steps.size() - 1)].normal;
    own.normal.push_back(own.face != nullptr ? turn * own.face->face().normal() : outward);
    own.u.push_back(own.face != nullptr ? turn * own.face->face().u : outward.unitOrthogonal());
    own.v.push_back(own.face != nullptr ? turn * own.face->face().v
                                        : outward.cross(outward.unitOrthogonal()));
  }
  return own;
}

LastingForce LastingForces::force(std::size_t contact) {
  if (contact >= motion_.contacts.size() || motion_.contacts[contact].steps.empty()) {
    throw core::InputError(
        fmt::format("lasting forces: no contact {}, or one without steps", contact));
  }
  LastingForce result = silence(motion_.contacts[contact]);
  switch (options_.excitation) {
    case ContactExcitation::height_profile:
      add_profile(contact, result);
      break;
    case ContactExcitation::texel_impulses:
      add_texel_impulses(contact, result);
      break;
    case ContactExcitation::solver_impulses:
      add_solver_impulses(contact, result);
      break;
  }
  return result;
}

LastingForces::Felt LastingForces::feel(const LastingContact& contact, std::size_t side,
                                        const Side& own, double force, double time) const {
  Felt felt;
  const ContactPath::Place at = own.path.at(time);
  const double speed = at.velocity.norm();
  const double moving = moving_fraction(speed);
  if (moving == 0) return felt;
  const double way_between = speed / options_.sample_rate;
  const double place = time / motion_.step;
  if (const auto uv = own.face != nullptr ? own.face->place(at.point) : std::nullopt) {
    const double modulus = contact_modulus(bodies_[contact.bodies[0]], bodies_[contact.bodies[1]]);
    const double radius = radius_of(contact.bodies[1 - side]);
    const double patch = modulus > 0 ? 2 * std::cbrt(0.75 * force * radius / modulus) : 0;
    const render::maps::SurfaceDetail detail =
        own.face->detail(*uv, std::max(apart * way_between, patch));
    const Vec3 &u = own.face->face().u, &v = own.face->face().v;
    const Eigen::Vector2d way(at.velocity.dot(u), at.velocity.dot(v));
    const Eigen::Vector2d gain(at.acceleration.dot(u), at.acceleration.dot(v));
    felt.rise = way.dot(detail.curvature * way) + detail.slope.dot(gain);
    felt.lean =
        -moving * own.sign *
        (detail.slope.x() * between(own.u, place) + detail.slope.y() * between(own.v, place));
  }
  if (own.noise) {
    const Eigen::Vector2d noise = moving * own.noise->at(at.point, 2 * way_between);
    felt.noise = noise[0];
    felt.cross_noise = noise[1];
  }
  return felt;
}

void LastingForces::add_profile(std::size_t number, LastingForce& result) {
  const LastingContact& contact = motion_.contacts[number];
  const std::array<Side, 2> sides = {side_of(contact, 0), side_of(contact, 1)};
  const double mass = reduced_mass(contact);
  const double friction =
      std::sqrt(bodies_[contact.bodies[0]].friction * bodies_[contact.bodies[1]].friction);
  const double length = static_cast<double>(contact.steps.size()) * motion_.step;
  const double begin = static_cast<double>(contact.first_step) * motion_.step;
  std::vector<Vec3> slips, normals;
  for (const ContactStep& step : contact.steps) {
    slips.push_back(step.slip);
    normals.push_back(step.normal);
  }
  std::vector<bool> still;
  for (std::size_t k = 0; k < contact.steps.size(); ++k) {
    still.push_back(std::max(sides[0].path.fastest(k), sides[1].path.fastest(k)) <= at_rest);
  }
  for (Eigen::Index n = 0; n < result.force.cols(); ++n) {
    const double time = static_cast<double>(result.first_sample + static_cast<std::size_t>(n)) /
                            options_.sample_rate -
                        begin;
    const double place = time / motion_.step;
    if (still[std::min(static_cast<std::size_t>(std::max(0.0, place)), still.size() - 1)]) continue;
    const double force = between(normal_[number], place);
    if (!(force > 0)) continue;
    const Felt a = feel(contact, 0, sides[0], force, time);
    const Felt b = feel(contact, 1, sides[1], force, time);
    const double rough = options_.roughness * force;
    const double normal =
        std::max(0.0, force + between(share_[number], place) * mass * (a.rise + b.rise) +
                          rough * (a.noise + b.noise));
    const Vec3 slip = between(slips, place);
    const double speed = slip.norm();
    const Vec3 rubs = speed > 0 ? Vec3(friction * moving_fraction(speed) / speed * slip) : slip;
    result.force.col(n) = fade(time, length) *
                          ((normal - force) * between(normals, place) + normal * (a.lean + b.lean) -
                           (normal - force + rough * (a.cross_noise + b.cross_noise)) * rubs);
  }
}

void LastingForces::add_impulse(const Vec3& impulse, double time, LastingForce& result) const {
  // Over the two samples beside it, as a force of straight lines has it.
  const double place = time * options_.sample_rate - static_cast<double>(result.first_sample);
  const double whole = std::floor(place);
  const auto sample = static_cast<Eigen::Index>(whole);
  const double fraction = place - whole;
  const Vec3 force = impulse * options_.sample_rate;
  if (sample >= 0 && sample < result.force.cols())
    result.force.col(sample) += (1 - fraction) * force;
  if (sample + 1 >= 0 && sample + 1 < result.force.cols()) {
    result.force.col(sample + 1) += fraction * force;
  }
}

void LastingForces::add_texel_impulses(std::size_t number, LastingForce& result) {
  const LastingContact& contact = motion_.contacts[number];
  const double mass = reduced_mass(contact);
  const double begin = static_cast<double>(contact.first_step) * motion_.step;
  for (std::size_t side = 0; side < 2; ++side) {
    const Side own = side_of(contact, side);
    if (own.face == nullptr) continue;
    const render::maps::TexturedFace& face = own.face->face();
    double before = 0;
    bool touched = false;
    Eigen::Vector2d last_uv = Eigen::Vector2d::Zero();
    double last_time = 0;
    for (std::size_t k = 0; k < contact.steps.size(); ++k) {
      const double from = static_cast<double>(k) * motion_.step;
      const double way = own.path.at(from).velocity.norm() * motion_.step;
      const auto looks = std::max(1.0, std::ceil(texel_steps * way / face.map->texel));
      for (double look = 0; look < looks; ++look) {
        const double time = from + (look + 0.5) / looks * motion_.step;
        const ContactPath::Place at = own.path.at(time);
        const auto uv = own.face->place(at.point);
        if (!uv) {
          touched = false;
          continue;
        }
        const Vec3 normal = render::maps::texel_normal(*face.map, *uv);
        const double rise =
            -(at.velocity.dot(face.u) * normal.x() + at.velocity.dot(face.v) * normal.y()) /
            normal.z();
        const double place = time / motion_.step;
        const double momentum = between(share_[number], place) * mass * rise;
        if (touched && momentum != before) {
          const double edge =
              last_time + edge_between(last_uv, *uv, face.map->texel) * (time - last_time);
          add_impulse(own.sign * (momentum - before) * between(own.normal, place), begin + edge,
                      result);
        }
        before = momentum;
        last_uv = *uv;
        last_time = time;
        touched = true;
      }
    }
  }
}

void LastingForces::add_solver_impulses(std::size_t number, LastingForce& result) const {
  const LastingContact& contact = motion_.contacts[number];
  for (std::size_t k = 0; k < contact.steps.size(); ++k) {
    add_impulse(contact.steps[k].force * motion_.step,
                static_cast<double>(contact.first_step + k) * motion_.step, result);
  }
}

}  // namespace carillon::synth::motion
