#include "synth/modal/streaming_renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace carillon::synth::modal {

namespace {

/// A year of samples is exact in what follows [s].
constexpr double longest_delay = 3e7;

bool fits(const Eigen::MatrixXd& gains, std::size_t rows, std::size_t modes) {
  return gains.size() == 0 || (gains.rows() == static_cast<Eigen::Index>(rows) &&
                               gains.cols() == static_cast<Eigen::Index>(modes));
}

/// Adds to voices by rotation; they keep the order of their rotations, so that one walk finds them.
void add_values(const Resonances& resonances, const std::vector<std::complex<double>>& values,
                std::vector<Voice>& voices) {
  auto voice = voices.begin();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] == 0.0) continue;
    const Rotation* rotation = &resonances.rotations[i];
    while (voice != voices.end() && voice->rotation < rotation) ++voice;
    if (voice != voices.end() && voice->rotation == rotation) {
      voice->value += values[i];
    } else {
      voice = voices.insert(voice, {rotation, values[i]});
    }
  }
}

}  // namespace

StreamingRenderer::StreamingRenderer(std::size_t rows, double sample_rate)
    : sample_rate_(sample_rate), rows_(rows) {
  if (rows == 0) throw core::InputError("streaming renderer: no rows");
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw core::InputError(
        fmt::format("streaming renderer: sample rate must be positive, not {} Hz", sample_rate));
  }
}

std::size_t StreamingRenderer::add_body(std::span<const double> eigenvalues,
                                        std::span<const double> decay_rates,
                                        const Readout& readout) {
  const std::size_t modes = eigenvalues.size();
  const auto gains = gains_of(readout);
  const bool fitting = std::all_of(gains.begin(), gains.end(), [&](const Eigen::MatrixXd* matrix) {
    return fits(*matrix, rows_, modes);
  });
  if (readout.delays.size() != rows_ || !fitting) {
    throw core::InputError(
        fmt::format("streaming renderer: a readout of {} rows does not fit {} modes and {} rows",
                    readout.delays.size(), modes, rows_));
  }
  for (const Eigen::MatrixXd* matrix : gains) {
    if (!matrix->allFinite()) throw core::InputError("streaming renderer: a gain is not finite");
  }
  for (const double delay : readout.delays) {
    if (delay >= 0 && delay < longest_delay) continue;
    throw core::InputError(fmt::format(
        "streaming renderer: a row's delay must be at least 0 and below a year, not {} s", delay));
  }
  Body body;
  body.resonances = make_resonances(eigenvalues, decay_rates, sample_rate_);
  body.readout = readout;
  body.rows.resize(rows_);
  for (Row& row : body.rows) row.voices.reserve(body.resonances.rotations.size());
  bodies_.push_back(std::move(body));
  return bodies_.size() - 1;
}

void StreamingRenderer::strike(std::size_t body, const Eigen::VectorXd& excitation,
                               const ContactForce& force, double delay) {
  if (body >= bodies_.size()) {
    throw core::InputError(fmt::format("streaming renderer: no body {}", body));
  }
  Body& struck = bodies_[body];
  const std::size_t modes = struck.resonances.eigenvalues.size();
  if (excitation.size() != static_cast<Eigen::Index>(modes) || !excitation.allFinite()) {
    throw core::InputError(
        fmt::format("streaming renderer: excitation must be {} finite values, not {}", modes,
                    excitation.size()));
  }
  if (!(delay >= 0 && delay < longest_delay)) {
    throw core::InputError(fmt::format(
        "streaming renderer: delay must be at least 0 and below a year, not {} s", delay));
  }
  check(force);
  if (!(force.duration * sample_rate_ <= longest_contact)) {
    throw core::InputError(
        fmt::format("streaming renderer: a contact of {:.4g} s is longer than {:.4g} s",
                    force.duration, longest_contact / sample_rate_),
        "shorten the force, or use synthesize() for a single strike");
  }
  for (std::size_t r = 0; r < rows_; ++r) {
    Row& row = struck.rows[r];
    if (row.waiting == row.strikes.size()) row.strikes.emplace_back();
    Strike& strike = row.strikes[row.waiting++];
    const long double start = static_cast<long double>(delay) + struck.readout.delays[r];
    const long double stop = start + force.duration;
    const long double first = std::ceil(start * sample_rate_);
    const long double free = std::ceil(stop * sample_rate_);
    strike.first = position_ + static_cast<std::uint64_t>(first);
    strike.free = position_ + static_cast<std::uint64_t>(free);
    strike.begun = false;
    const StrikeTiming timing = {static_cast<std::size_t>(free - first),
                                 std::max(0.0L, first / sample_rate_ - start),
                                 std::max(0.0L, free / sample_rate_ - stop)};
    respond(struck.resonances, struck.readout, static_cast<Eigen::Index>(r), excitation, force,
            timing, strike.response);
    if (strike.response.forced.turning != 0.0) {
      strike.turn =
          make_rotation(0, 2 * std::numbers::pi_v<long double> / force.duration, sample_rate_);
    }
  }
}

std::size_t StreamingRenderer::voices() const {
  std::size_t count = 0;
  for (const Body& body : bodies_) {
    for (const Row& row : body.rows) count += row.voices.size() + row.near_critical.size();
  }
  return count;
}

void StreamingRenderer::render(std::span<float> samples) {
  if (samples.size() % rows_ != 0) {
    throw core::InputError(
        fmt::format("streaming renderer: {} samples are no whole number for {} "
                    "rows",
                    samples.size(), rows_));
  }
  const std::size_t total = samples.size() / rows_;
  for (std::size_t done = 0; done < total; done += block_size) {
    const std::size_t count = std::min(block_size, total - done);
    for (std::size_t r = 0; r < rows_; ++r) {
      sum_.samples.fill(0);
      for (Body& body : bodies_) render_row(body, body.rows[r], count);
      store_block(sum_, samples.subspan(r * total + done, count));
    }
    position_ += count;
  }
}

void StreamingRenderer::render_row(const Body& body, Row& row, std::size_t count) {
  if (row.voices.empty() && row.near_critical.empty() && row.waiting == 0) return;
  for (std::size_t offset = 0; offset < count;) {
    const std::uint64_t now = position_ + offset;
    std::uint64_t next = position_ + count;
    for (std::size_t i = 0; i < row.waiting;) {
      Strike& strike = row.strikes[i];
      if (!strike.begun && strike.first <= now) {
        strike.begun = true;
        row.peak = 0;
        row.next_check = strike.free + block_size;
        add_values(body.resonances, strike.response.begin, row.voices);
      }
      if (strike.free <= now) {
        add_values(body.resonances, strike.response.end, row.voices);
        add_motions(body.resonances, strike.response.near_critical, row.near_critical);
        std::swap(strike, row.strikes[--row.waiting]);
        continue;
      }
      next = std::min(next, strike.begun ? strike.free : strike.first);
      ++i;
    }
    const auto stretch = static_cast<std::size_t>(next - now);
    render_stretch(body, row, now, offset, stretch);
    offset += stretch;
  }
}

void StreamingRenderer::render_stretch(const Body& body, Row& row, std::uint64_t begin,
                                       std::size_t offset, std::size_t count) {
  if (begin >= row.next_check) {
    row.next_check = begin + block_size;
    const std::size_t parts = body.resonances.rotations.size();
    drop_below(parts == 0 ? 0 : inaudible * row.peak / static_cast<double>(parts), row.voices);
    drop_gone(body.resonances, row.near_critical);
  }
  // Vectors may read a little beyond what is asked for.
  std::fill_n(block_.samples.begin(), std::min(block_size, count + 2 * max_lanes), 0.0);
  for (std::size_t i = 0; i < row.waiting; ++i) {
    Strike& strike = row.strikes[i];
    if (!strike.begun) continue;
    const auto into = static_cast<std::size_t>(begin - strike.first);
    for (std::size_t n = 0; n < count; ++n) {
      block_.samples[n] += strike.response.direct[into + n] + strike.response.forced.constant;
    }
    if (strike.response.forced.turning != 0.0) {
      Voice turning = {&strike.turn, strike.response.forced.turning};
      add_voices({&turning, 1}, count, block_);
      move_on({&turning, 1}, count);
      strike.response.forced.turning = turning.value;
    }
  }
  ring_on(body.resonances, row.near_critical, std::span(block_.samples).first(count));
  add_voices(row.voices, count, block_);
  move_on(row.voices, count);
  row.peak = std::max(row.peak, peak_of(block_, count));
  for (std::size_t n = 0; n < count; ++n) sum_.samples[offset + n] += block_.samples[n];
}

std::vector<float> synthesize_strikes(const RingDown& rings, const ContactForce& force,
                                      std::span<const double> times, double sample_rate,
                                      std::size_t count) {
  StreamingRenderer renderer(rings.readout.delays.size(), sample_rate);
  const std::size_t body = renderer.add_body(rings.eigenvalues, rings.decay_rates, rings.readout);
  for (const double time : times) renderer.strike(body, rings.excitation, force, time);
  std::vector<float> samples(rings.readout.delays.size() * count);
  renderer.render(samples);
  return samples;
}

}  // namespace carillon::synth::modal
