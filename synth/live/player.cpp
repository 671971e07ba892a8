#include "synth/live/player.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::synth::live {

namespace {

/// Times beyond it are slips, and the renderer's own limit is a year [s].
constexpr double latest_time = 1e7;

void check_time(const std::optional<double>& time) {
  if (!time || (*time >= 0 && *time < latest_time)) return;
  throw core::InputError(fmt::format(
      "an event's time must be at least 0 s and below {} s, not {} s", latest_time, *time));
}

}  // namespace

Player::Player(std::size_t rows, double sample_rate, double gain)
    : rows_(rows),
      sample_rate_(sample_rate),
      gain_(gain),
      renderer_(rows, sample_rate),
      samples_(rows * block) {}

std::size_t Player::add_body(std::span<const double> eigenvalues,
                             std::span<const double> decay_rates, const modal::Readout& readout) {
  return renderer_.add_body(eigenvalues, decay_rates, readout);
}

void Player::strike(std::size_t body, const Eigen::VectorXd& excitation,
                    const modal::ContactForce& force, std::optional<double> time) {
  check_time(time);
  auto event = std::make_unique<Event>();
  event->time = time;
  event->strike = renderer_.prepare_strike(body, excitation, force);
  send(std::move(event));
}

void Player::change(std::size_t body, std::span<const double> eigenvalues,
                    std::span<const double> decay_rates, std::optional<double> time) {
  check_time(time);
  auto event = std::make_unique<Event>();
  event->time = time;
  event->change = renderer_.prepare_change(body, eigenvalues, decay_rates);
  send(std::move(event));
}

void Player::stop(std::optional<double> time) {
  check_time(time);
  auto event = std::make_unique<Event>();
  event->time = time;
  event->stop = true;
  send(std::move(event));
}

void Player::send(std::unique_ptr<Event> event) {
  // Who sends also frees what the playing thread is done with; several may at once.
  done_.take_all([](std::unique_ptr<Event>) {});
  done_strikes_.take_all([](std::unique_ptr<modal::StreamedStrike>) {});
  done_changes_.take_all([](std::unique_ptr<modal::StreamedChange>) {});
  ++sent_;
  inbox_.send(std::move(event));
}

void Player::begin(std::unique_ptr<Event> event) {
  const double now = static_cast<double>(renderer_.position()) / sample_rate_;
  double delay = 0;
  if (event->time) {
    delay = *event->time - now;
    // Half a nanosecond is rounding.
    if (delay < -5e-10) {
      ++late_;
      latest_ = std::max(latest_.load(), -delay);
    }
    delay = std::max(0.0, delay);
  }
  if (event->strike) renderer_.begin(std::move(event->strike), delay);
  if (event->change) renderer_.begin(std::move(event->change), delay);
  if (event->stop) {
    const auto in = static_cast<std::uint64_t>(std::ceil(delay * sample_rate_));
    stop_at_ = std::min(stop_at_, renderer_.position() + in);
  }
  // Before it counts as begun, so that who looks meanwhile does not find it nowhere.
  ++voices_;
  ++events_;
  done_.send(std::move(event));
}

void Player::play(std::span<float> frames) noexcept {
  const std::size_t total = frames.size() / rows_;
  for (std::size_t done = 0; done < total; done += block) {
    inbox_.take_all([this](std::unique_ptr<Event> event) { begin(std::move(event)); });
    const std::size_t count = std::min(block, total - done);
    const std::uint64_t first = renderer_.position();
    renderer_.render(std::span(samples_).first(rows_ * count));
    for (std::size_t n = 0; n < count; ++n) {
      const double gain = first + n < stop_at_ ? gain_ : 0;
      for (std::size_t r = 0; r < rows_; ++r) {
        frames[(done + n) * rows_ + r] = static_cast<float>(gain * samples_[r * count + n]);
      }
    }
    while (auto strike = renderer_.take_ended_strike()) done_strikes_.send(std::move(strike));
    while (auto change = renderer_.take_ended_change()) done_changes_.send(std::move(change));
  }
  position_ = renderer_.position();
  const bool stops = stop_at_ != UINT64_MAX && renderer_.position() < stop_at_;
  voices_ = renderer_.voices() + renderer_.contacts() + (stops ? 1 : 0);
  if (renderer_.position() >= stop_at_) stopped_ = true;
}

Played Player::played() const {
  Played played;
  played.samples = position_;
  played.events = events_;
  played.late = late_;
  played.latest = latest_;
  // What was sent after the last block is still to come.
  played.voices = voices_ + (sent_ - events_);
  played.stopped = stopped_;
  return played;
}

}  // namespace carillon::synth::live
