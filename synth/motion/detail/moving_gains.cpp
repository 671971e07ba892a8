#include "synth/motion/detail/moving_gains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.hpp"

namespace carillon::synth::motion {

namespace {

/// Pieces of the surface over which the dry signal's mean is taken, at least.
constexpr std::size_t pieces = 2000;
/// A body that moves by less than this fraction stands still.
constexpr double still_gain = 1e-7;

}  // namespace

modal::Readout mean_square_velocity(const solvers::modes::Modes& modes) {
  const surface::OuterTriangles surface = surface::outer_triangles(modes.surface, pieces);
  const Eigen::MatrixXd flux = modes.shapes.at_nodes().cast<double>() * surface.flux_weights;
  modal::Readout readout;
  readout.delays = {0.0};
  readout.velocity = Eigen::MatrixXd::Zero(1, flux.rows());
  for (std::size_t t = 0; t < surface.size(); ++t) {
    if (!(surface.areas[t] > 0)) continue;
    readout.velocity += flux.col(static_cast<Eigen::Index>(t)).cwiseAbs2().transpose() /
                        (surface.areas[t] * surface.area);
  }
  readout.velocity = readout.velocity.cwiseSqrt().eval();
  return readout;
}

MovingGains::MovingGains(const Motion& motion, std::size_t body, const SoundingBody& sounding,
                         std::span<const modal::Listener> listeners, double turn, bool moving)
    : motion_(motion),
      body_(body),
      sounding_(sounding),
      listeners_(listeners),
      turn_(turn),
      last_(moving ? motion.states.size() - 1 : 0) {
  if (listeners.empty()) {
    before_ = mean_square_velocity(*sounding.modes);
    last_ = 0;
    made_ = true;
  } else if (sounding.field == nullptr) {
    throw core::InputError(
        fmt::format("moving sound: body {} has listeners, but no fit of its radiation", body));
  }
}

Vec3 MovingGains::listener_at(std::size_t step, std::size_t row) const {
  return motion_.states[std::min(step, last_)][body_].pose.to_body(listeners_[row].position);
}

std::vector<double> MovingGains::flight_times(std::size_t row) const {
  if (listeners_.empty()) return {0.0};
  std::vector<double> times;
  for (std::size_t step = 0; step <= last_; ++step) {
    const double way = (listener_at(step, row) - sounding_.field->sources().centroid).norm();
    times.push_back(way / modal::speed_of_sound);
  }
  return times;
}

bool MovingGains::near(std::size_t from, std::size_t to, double turn) const {
  const Vec3& centre = sounding_.field->sources().centroid;
  for (std::size_t row = 0; row < listeners_.size(); ++row) {
    const Vec3 a = listener_at(from, row) - centre, b = listener_at(to, row) - centre;
    const double fraction = b.norm() / a.norm();
    const double across = (a.normalized() - b.normalized()).norm();
    if (!(across <= turn && std::abs(fraction - 1) <= turn)) return false;
  }
  return true;
}

modal::Readout MovingGains::gains_at(std::size_t step) {
  ++poses_;
  std::vector<modal::Listener> places;
  for (std::size_t row = 0; row < listeners_.size(); ++row) {
    places.push_back({listener_at(step, row)});
  }
  try {
    return radiation::pressure_readout(sounding_.field->pressure_at(places), *sounding_.modes,
                                       sounding_.decay_rates);
  } catch (const core::InputError& error) {
    throw core::InputError(fmt::format("body {} at {:.4g} s: {}", body_,
                                       static_cast<double>(step) * motion_.step, error.message()),
                           "move the listener away from where the body goes");
  }
}

DrivenGains MovingGains::over(std::size_t step) {
  step = std::min(step, last_);
  const std::size_t end = std::min(step + 1, last_);
  if (!made_ || step < before_at_ || end > after_at_) {
    const bool goes_on = made_ && step == after_at_ && after_at_ > before_at_;
    if (goes_on) {
      before_ = std::move(after_);
    } else if (!made_ || step != before_at_) {
      before_ = gains_at(step);
    }
    made_ = true;
    before_at_ = step;
    after_at_ = end;
    while (after_at_ < last_ && near(step, after_at_ + 1, turn_)) ++after_at_;
    still_ = true;
    for (std::size_t k = step + 1; still_ && k <= after_at_; ++k)
      still_ = near(step, k, still_gain);
    after_ = still_ ? before_ : gains_at(after_at_);
  }
  if (still_) return {&before_, &before_, 0, 0};
  const auto whole = static_cast<double>(after_at_ - before_at_);
  return {&before_, &after_, static_cast<double>(step - before_at_) / whole,
          static_cast<double>(end - before_at_) / whole};
}

}  // namespace carillon::synth::motion
