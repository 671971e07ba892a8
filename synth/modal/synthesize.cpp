#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/modal/modal_response.hpp"
#include "synth/modal/near_critical.hpp"
#include "synth/modal/resonators.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/modal/row_response.hpp"

namespace carillon::synth::modal {

namespace {

void check(const RingDown& rings) {
  const auto modes = static_cast<Eigen::Index>(rings.eigenvalues.size());
  const auto rows = static_cast<Eigen::Index>(rings.readout.delays.size());
  bool fits =
      rings.decay_rates.size() == rings.eigenvalues.size() && rings.excitation.size() == modes;
  if (!rings.excitation.allFinite()) throw core::InputError("synthesize: excitation not finite");
  const Readout& readout = rings.readout;
  for (const Eigen::MatrixXd* gains : gains_of(readout)) {
    fits = fits && (gains->size() == 0 || (gains->rows() == rows && gains->cols() == modes));
    if (!gains->allFinite()) throw core::InputError("synthesize: a gain is not finite");
  }
  if (!fits) {
    throw core::InputError(fmt::format(
        "synthesize: {} eigenvalues, {} decay rates, excitation and readout ({} rows) do "
        "not belong together",
        modes, rings.decay_rates.size(), rows));
  }
  for (const double delay : rings.readout.delays) {
    if (!(delay >= 0) || !std::isfinite(delay)) {
      throw core::InputError(
          fmt::format("synthesize: delay must be finite and not negative, not {} s", delay));
    }
  }
}

/// First sample at or after a time, at most `count`.
std::size_t first_sample(long double time, double sample_rate, std::size_t count) {
  const long double sample = std::ceil(time * sample_rate);
  return sample < static_cast<long double>(count) ? static_cast<std::size_t>(sample) : count;
}

/// The contact: exponentials, the forced motion and what no exponential gives.
/// @return peak
double render_contact(const Resonances& resonances, const RowResponse& response,
                      const ContactForce& force, std::vector<Voice>& voices,
                      std::span<float> samples) {
  std::vector<Voice> parts;
  parts.reserve(voices.size() + 1);
  for (const Voice& voice : voices) {
    if (voice.value != 0.0) parts.push_back(voice);
  }
  Rotation turn;
  if (response.forced.turning != 0.0) {
    turn = make_rotation(0, 2 * std::numbers::pi_v<long double> / force.duration,
                         resonances.sample_rate);
    parts.push_back({&turn, response.forced.turning});
  }
  double peak = 0;
  SampleBlock block{};
  for (std::size_t begin = 0; begin < samples.size(); begin += block_size) {
    const std::size_t count = std::min(block_size, samples.size() - begin);
    for (std::size_t i = 0; i < count; ++i) {
      block.samples[i] = response.direct[begin + i] + response.forced.constant;
    }
    add_voices(parts, count, block);
    move_on(parts, count);
    move_on(voices, count);
    peak = std::max(peak, store_block(block, samples.subspan(begin, count)));
  }
  return peak;
}

/// One row, from the arrival of its sound on.
void synthesize_row(const Resonances& resonances, const RingDown& rings, Eigen::Index row,
                    const ContactForce& force, std::span<float> samples) {
  const double rate = resonances.sample_rate;
  const double delay = rings.readout.delays[static_cast<std::size_t>(row)];
  const long double contact_end = static_cast<long double>(delay) + force.duration;
  const std::size_t first = first_sample(delay, rate, samples.size());
  const std::size_t free = first_sample(contact_end, rate, samples.size());
  const auto time_after = [&](std::size_t sample, long double origin) {
    return std::max(0.0L, static_cast<long double>(sample) / rate - origin);
  };
  const StrikeTiming timing = {free - first, time_after(first, delay),
                               time_after(free, contact_end)};
  RowResponse response;
  respond(resonances, rings.readout, row, rings.excitation, force, timing, response);

  std::vector<Voice> voices(resonances.rotations.size());
  for (std::size_t i = 0; i < voices.size(); ++i) {
    voices[i] = {&resonances.rotations[i], response.begin[i]};
  }
  std::fill_n(samples.begin(), first, 0.0F);
  double peak =
      render_contact(resonances, response, force, voices, samples.subspan(first, free - first));
  for (std::size_t i = 0; i < voices.size(); ++i) voices[i].value += response.end[i];

  std::vector<NearCritical> near_critical;
  add_motions(resonances, response.near_critical, near_critical);
  drop_below(0, voices);
  const double fraction = voices.empty() ? 0 : inaudible / static_cast<double>(voices.size());
  SampleBlock block;
  for (std::size_t begin = free; begin < samples.size(); begin += block_size) {
    const std::size_t count = std::min(block_size, samples.size() - begin);
    drop_below(fraction * peak, voices);
    block.samples.fill(0);
    ring_on(resonances, near_critical, std::span(block.samples).first(count));
    drop_gone(resonances, near_critical);
    add_voices(voices, count, block);
    move_on(voices, count);
    peak = std::max(peak, store_block(block, samples.subspan(begin, count)));
  }
}

}  // namespace

std::vector<float> synthesize(const RingDown& rings, const ContactForce& force, double sample_rate,
                              std::size_t count) {
  check(force);
  check(rings);
  const Resonances resonances = make_resonances(rings.eigenvalues, rings.decay_rates, sample_rate);
  const std::size_t rows = rings.readout.delays.size();
  std::vector<float> result(rows * count);
  for (std::size_t row = 0; row < rows; ++row) {
    synthesize_row(resonances, rings, static_cast<Eigen::Index>(row), force,
                   std::span(result).subspan(row * count, count));
  }
  return result;
}

namespace {

bool below_nyquist(const RingDown& rings, std::size_t mode, double sample_rate) {
  const double omega = std::sqrt(rings.eigenvalues[mode]);
  const double d = rings.decay_rates[mode];
  const double damped = d < omega ? std::sqrt((omega - d) * (omega + d)) : 0;
  return damped < std::numbers::pi * sample_rate;
}

}  // namespace

std::size_t modes_above_nyquist(const RingDown& rings, double sample_rate) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < rings.eigenvalues.size(); ++i) {
    if (!below_nyquist(rings, i, sample_rate)) ++count;
  }
  return count;
}

std::size_t sounding_modes(const RingDown& rings, double sample_rate) {
  const Readout& readout = rings.readout;
  std::size_t count = 0;
  for (std::size_t i = 0; i < rings.eigenvalues.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    bool heard = false;
    for (const Eigen::MatrixXd* gains : gains_of(readout)) {
      heard = heard || (gains->size() > 0 && !gains->col(column).isZero(0));
    }
    if (heard && rings.excitation[column] != 0 && below_nyquist(rings, i, sample_rate)) ++count;
  }
  return count;
}

}  // namespace carillon::synth::modal
