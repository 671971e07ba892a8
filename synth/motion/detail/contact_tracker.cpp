#include "synth/motion/detail/contact_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "synth/contact/striker.hpp"
#include "synth/motion/detail/collision_shape.hpp"

namespace carillon::synth::motion {

namespace {

constexpr double longest_gap = 4;    ///< steps without a push that a contact outlives
constexpr double shock = 5;          ///< times what a contact bears that count as a strike
constexpr double same_place = 0.02;  ///< of the smaller body's reach: the same place
constexpr double forget = 0.2;       ///< weight of the newest part in what a contact usually bears

/// Hertz's contact time of two bodies that meet [s]. Where both are flat the radius is the smaller
/// body's reach.
double hertz_duration(const MovingBody& a, const MovingBody& b, double mass, double speed) {
  contact::Striker striker;
  striker.name = a.name;
  striker.mass = mass;
  const double curvature = a.curvature + b.curvature;
  striker.radius = curvature > 0 ? 1 / curvature : std::min(reach_of(a), reach_of(b));
  striker.youngs_modulus = a.youngs_modulus;
  striker.poisson_ratio = a.poisson_ratio;
  contact::StruckBody struck;
  struck.mass = std::numeric_limits<double>::infinity();
  struck.youngs_modulus = b.youngs_modulus;
  struck.poisson_ratio = b.poisson_ratio;
  return contact::hertz_contact(striker, struck, speed).duration;
}

}  // namespace

double effective_mass(const MovingBody& body, const Pose& pose, const Vec3& world_point,
                      const Vec3& direction) {
  if (body.fixed) return std::numeric_limits<double>::infinity();
  const Vec3 arm = world_point - pose.to_world(body.rigid.centre);
  const Vec3 moment = body.rigid.axes.transpose() * (pose.turn.conjugate() * arm.cross(direction));
  const double turning = (moment.array().square() / body.rigid.inertia.array()).sum();
  return 1 / (1 / body.rigid.mass + turning);
}

double ContactTracker::pair_mass(const SolvedContact& contact, const Vec3& place,
                                 std::span<const BodyState> states) const {
  double inverse = 0;
  for (const std::size_t b : contact.bodies) {
    inverse += 1 / effective_mass(bodies_[b], states[b].pose, place, contact.normal);
  }
  return 1 / inverse;
}

double ContactTracker::speed_bound(const std::array<std::size_t, 2>& pair,
                                   std::span<const BodyState> states) const {
  double bound = (states[pair[0]].velocity - states[pair[1]].velocity).norm();
  for (const std::size_t b : pair) bound += states[b].spin.norm() * reach_of(bodies_[b]);
  return bound;
}

ContactTracker::Track* ContactTracker::find(const SolvedContact& contact, const Vec3& place,
                                            double time, std::span<const BodyState> states) {
  Track* nearest = nullptr;
  double minimum = std::numeric_limits<double>::infinity();
  const auto& pair = contact.bodies;
  const auto tracks = tracks_.find(pair);
  if (tracks == tracks_.end()) return nullptr;
  // Bodies that travel together carry their places of contact along.
  const double travel = std::max(states[pair[0]].velocity.norm(), states[pair[1]].velocity.norm());
  const double near = same_place * std::min(reach_of(bodies_[pair[0]]), reach_of(bodies_[pair[1]]));
  const double speed = speed_bound(pair, states) + travel;
  for (Track& track : tracks->second) {
    const double distance = (track.place - place).norm();
    const double reach = near + 1.5 * speed * (time - track.last);
    if (distance > reach || distance >= minimum) continue;
    minimum = distance;
    nearest = &track;
  }
  return nearest;
}

void ContactTracker::strike(const SolvedContact& contact, double begin, double speed, double mass) {
  Impact impact;
  impact.time = std::max(0.0, begin - contact.begun);
  impact.bodies = contact.bodies;
  impact.points = contact.points;
  impact.normal = contact.normal;
  impact.impulse = contact.impulse;
  impact.speed = speed;
  impact.duration =
      hertz_duration(bodies_[contact.bodies[0]], bodies_[contact.bodies[1]], mass, speed);
  impacts_.push_back(impact);
}

void ContactTracker::add(std::span<const SolvedContact> contacts, double begin, double length,
                         std::span<const BodyState> states) {
  const double end = begin + length;
  const auto was_touched = [&](const Track* track) {
    return track != nullptr && begin - track->last <= 1.5 * length;
  };
  const auto place_of = [&](const SolvedContact& contact) {
    return states[contact.bodies[0]].pose.to_world(contact.points[0]);
  };
  // Only a strike can send a shock through what is at rest.
  const bool struck = std::any_of(contacts.begin(), contacts.end(), [&](const auto& contact) {
    return contact.approach >= options_.min_speed &&
           !was_touched(find(contact, place_of(contact), end, states));
  });
  for (const SolvedContact& contact : contacts) {
    const Vec3 place = place_of(contact);
    const double mass = pair_mass(contact, place, states);
    if (!std::isfinite(mass)) continue;
    Track* track = find(contact, place, end, states);
    const bool touched = was_touched(track);
    const double push = contact.impulse.dot(contact.normal);
    const bool lands = !touched && contact.approach >= options_.min_speed;
    const bool shocked =
        touched && struck && push > shock * track->usual * length + mass * options_.min_speed;
    if (lands || shocked) {
      strike(contact, begin, lands ? contact.approach : push / mass, mass);
    }
    if (track == nullptr) {
      track = &tracks_[contact.bodies].emplace_back();
      track->contact.bodies = contact.bodies;
    }
    track->place = place;
    track->last = end;
    const double force = push / length;
    track->usual = touched ? (1 - forget) * track->usual + forget * force : force;
    if (lands || shocked) continue;
    track->pushed = true;
    track->now.points = contact.points;
    track->now.normal = contact.flat_normal;
    track->now.force += contact.impulse;
    track->now.slip = contact.slip;
  }
}

void ContactTracker::close(Track& track) {
  // A push or two between strikes is no contact.
  if (track.contact.steps.size() >= 3) contacts_.push_back(std::move(track.contact));
}

void ContactTracker::end_step(std::size_t step) {
  const double now = (static_cast<double>(step) + 1) * options_.time_step;
  const auto over = [&](Track& track) {
    if (now - track.last <= longest_gap * options_.time_step * (1 + 1e-9)) return false;
    close(track);
    return true;
  };
  for (auto pair = tracks_.begin(); pair != tracks_.end();) {
    std::vector<Track>& tracks = pair->second;
    for (Track& track : tracks) {
      if (track.pushed) end_step(track, step);
    }
    tracks.erase(std::remove_if(tracks.begin(), tracks.end(), over), tracks.end());
    pair = tracks.empty() ? tracks_.erase(pair) : std::next(pair);
  }
}

void ContactTracker::end_step(Track& track, std::size_t step) const {
  std::vector<ContactStep>& steps = track.contact.steps;
  if (steps.empty()) track.contact.first_step = step;
  track.now.force /= options_.time_step;
  // Moments without a push in between: nothing pushes, and the places go on in a straight line.
  const std::size_t missing = step - track.contact.first_step - steps.size();
  for (std::size_t k = 1; k <= missing; ++k) {
    const double fraction = 1 / static_cast<double>(missing - k + 2);
    ContactStep lifted = steps.back();
    for (std::size_t side = 0; side < 2; ++side) {
      lifted.points[side] += fraction * (track.now.points[side] - lifted.points[side]);
    }
    lifted.force.setZero();
    steps.push_back(lifted);
  }
  steps.push_back(track.now);
  track.now.force.setZero();
  track.pushed = false;
}

namespace {

/// Speed at which the places of contact move over each body.
void add_sweeps(LastingContact& contact, const Motion& motion) {
  const std::size_t count = contact.steps.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t from = k > 0 ? k - 1 : 0, to = std::min(k + 1, count - 1);
    const double time = static_cast<double>(to - from) * motion.step;
    for (std::size_t side = 0; side < 2; ++side) {
      const Pose& pose = motion.states[contact.first_step + k + 1][contact.bodies[side]].pose;
      const Vec3 way = contact.steps[to].points[side] - contact.steps[from].points[side];
      contact.steps[k].sweep[side] = time > 0 ? Vec3(pose.turn * way / time) : Vec3(Vec3::Zero());
    }
  }
}

}  // namespace

void ContactTracker::finish(Motion& motion) {
  for (auto& [pair, tracks] : tracks_) {
    for (Track& track : tracks) close(track);
  }
  tracks_.clear();
  std::stable_sort(impacts_.begin(), impacts_.end(),
                   [](const Impact& a, const Impact& b) { return a.time < b.time; });
  std::stable_sort(
      contacts_.begin(), contacts_.end(),
      [](const LastingContact& a, const LastingContact& b) { return a.first_step < b.first_step; });
  for (LastingContact& contact : contacts_) add_sweeps(contact, motion);
  motion.impacts = std::move(impacts_);
  motion.contacts = std::move(contacts_);
}

}  // namespace carillon::synth::motion
