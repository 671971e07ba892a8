#include "synth/modal/streaming_renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/error.hpp"
#include "synth/modal/row_motion.hpp"

namespace carillon::synth::modal {

namespace {

/// A year of samples is exact in what follows [s].
constexpr double longest_delay = 3e7;

bool fits(const Eigen::MatrixXd& gains, std::size_t rows, std::size_t modes) {
  return gains.size() == 0 || (gains.rows() == static_cast<Eigen::Index>(rows) &&
                               gains.cols() == static_cast<Eigen::Index>(modes));
}

std::size_t near_critical_modes(const Resonances& resonances) {
  const auto& modes = resonances.modes;
  return static_cast<std::size_t>(std::count_if(
      modes.begin(), modes.end(), [](const auto& mode) { return mode.rotations == 0; }));
}

void check_delay(double delay) {
  if (delay >= 0 && delay < longest_delay) return;
  throw core::InputError(fmt::format(
      "streaming renderer: delay must be at least 0 and below a year, not {} s", delay));
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
  auto values = std::make_unique<StreamedChange>();
  values->resonances = make_resonances(eigenvalues, decay_rates, sample_rate_);
  Body body;
  body.modes = modes;
  body.readout = readout;
  body.rows.resize(rows_);
  for (Row& row : body.rows) {
    row.values = values.get();
    row.voices.reserve(values->resonances.rotations.size());
    row.near_critical.reserve(near_critical_modes(values->resonances));
  }
  body.values.push_back(std::move(values));
  bodies_.push_back(std::move(body));
  return bodies_.size() - 1;
}

const StreamingRenderer::Body& StreamingRenderer::checked_body(std::size_t body) const {
  if (body >= bodies_.size()) {
    throw core::InputError(fmt::format("streaming renderer: no body {}", body));
  }
  return bodies_[body];
}

void StreamingRenderer::fill(StreamedStrike& strike, std::size_t body,
                             const Eigen::VectorXd& excitation, const ContactForce& force) const {
  const std::size_t modes = checked_body(body).modes;
  if (excitation.size() != static_cast<Eigen::Index>(modes) || !excitation.allFinite()) {
    throw core::InputError(
        fmt::format("streaming renderer: excitation must be {} finite values, not {}", modes,
                    excitation.size()));
  }
  check(force);
  if (!(force.duration * sample_rate_ <= longest_contact)) {
    throw core::InputError(
        fmt::format("streaming renderer: a contact of {:.4g} s is longer than {:.4g} s",
                    force.duration, longest_contact / sample_rate_),
        "shorten the force, or use synthesize() for a single strike");
  }
  strike.body = body;
  strike.excitation = excitation;
  strike.force = force;
  strike.rows.resize(rows_);
}

std::unique_ptr<StreamedStrike> StreamingRenderer::prepare_strike(std::size_t body,
                                                                  const Eigen::VectorXd& excitation,
                                                                  const ContactForce& force) const {
  auto strike = std::make_unique<StreamedStrike>();
  fill(*strike, body, excitation, force);
  const auto modes = static_cast<std::size_t>(excitation.size());
  for (StreamedStrike::InRow& row : strike->rows) {
    row.response.begin.reserve(2 * modes);
    row.response.end.reserve(2 * modes);
    row.response.direct.reserve(static_cast<std::size_t>(force.duration * sample_rate_) + 2);
    row.response.near_critical.reserve(modes);
  }
  return strike;
}

std::unique_ptr<StreamedChange> StreamingRenderer::prepare_change(
    std::size_t body, std::span<const double> eigenvalues,
    std::span<const double> decay_rates) const {
  const std::size_t modes = checked_body(body).modes;
  if (eigenvalues.size() != modes) {
    throw core::InputError(fmt::format("streaming renderer: a body of {} modes changes to {}",
                                       modes, eigenvalues.size()));
  }
  auto change = std::make_unique<StreamedChange>();
  change->body = body;
  change->resonances = make_resonances(eigenvalues, decay_rates, sample_rate_);
  change->motions.resize(modes);
  change->rows.resize(rows_);
  for (StreamedChange::InRow& row : change->rows) {
    row.voices.reserve(change->resonances.rotations.size());
    row.near_critical.reserve(near_critical_modes(change->resonances));
  }
  return change;
}

void StreamingRenderer::strike(std::size_t body, const Eigen::VectorXd& excitation,
                               const ContactForce& force, double delay) {
  std::unique_ptr<StreamedStrike> strike = take_ended_strike();
  if (!strike) strike = std::make_unique<StreamedStrike>();
  fill(*strike, body, excitation, force);
  begin(std::move(strike), delay);
}

void StreamingRenderer::change(std::size_t body, std::span<const double> eigenvalues,
                               std::span<const double> decay_rates, double delay) {
  while (take_ended_change()) continue;
  begin(prepare_change(body, eigenvalues, decay_rates), delay);
}

void StreamingRenderer::begin(std::unique_ptr<StreamedStrike> strike, double delay) {
  check_delay(delay);
  Body& struck = bodies_.at(strike->body);
  strike->rows_left = rows_;
  for (std::size_t r = 0; r < rows_; ++r) {
    StreamedStrike::InRow& in = strike->rows[r];
    const long double start = static_cast<long double>(delay) + struck.readout.delays[r];
    const long double stop = start + strike->force.duration;
    in.start = static_cast<long double>(position_) + start * sample_rate_;
    in.stop = static_cast<long double>(position_) + stop * sample_rate_;
    in.first = position_ + static_cast<std::uint64_t>(std::ceil(start * sample_rate_));
    in.free = position_ + static_cast<std::uint64_t>(std::ceil(stop * sample_rate_));
    in.begun = in.ended = false;
    const auto late = [&](std::uint64_t sample, long double time) {
      return std::max(0.0L, static_cast<long double>(sample - position_) / sample_rate_ - time);
    };
    in.first_time = late(in.first, start);
    in.free_time = late(in.free, stop);
    answer(struck, r, *strike);
  }
  struck.strikes.push_back(std::move(strike));
}

void StreamingRenderer::begin(std::unique_ptr<StreamedChange> change, double delay) {
  check_delay(delay);
  change->time =
      static_cast<long double>(position_) + static_cast<long double>(delay) * sample_rate_;
  OwnedList<StreamedChange>& values = bodies_.at(change->body).values;
  StreamedChange* place = values.first();
  while (place->next != nullptr && place->next->time <= change->time) place = place->next;
  values.insert_after(place, std::move(change));
}

void StreamingRenderer::answer(const Body& body, std::size_t row, StreamedStrike& strike) const {
  StreamedStrike::InRow& in = strike.rows[row];
  in.of = &body.rows[row].values->resonances;
  respond(*in.of, body.readout, static_cast<Eigen::Index>(row), strike.excitation, strike.force,
          {static_cast<std::size_t>(in.free - in.first), in.first_time, in.free_time}, in.response);
  if (in.response.forced.turning != 0.0) {
    in.turn =
        make_rotation(0, 2 * std::numbers::pi_v<long double> / strike.force.duration, sample_rate_);
  }
}

std::size_t StreamingRenderer::voices() const {
  std::size_t count = 0;
  for (const Body& body : bodies_) {
    for (const Row& row : body.rows) count += row.voices.size() + row.near_critical.size();
  }
  return count;
}

std::size_t StreamingRenderer::contacts() const {
  std::size_t count = 0;
  for (const Body& body : bodies_) {
    for (const StreamedStrike* s = body.strikes.first(); s != nullptr; s = s->next) ++count;
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
      for (Body& body : bodies_) render_row(body, r, count);
      store_block(sum_, samples.subspan(r * total + done, count));
    }
    position_ += count;
    for (Body& body : bodies_) take_ended(body);
  }
}

void StreamingRenderer::render_row(Body& body, std::size_t r, std::size_t count) {
  Row& row = body.rows[r];
  if (row.voices.empty() && row.near_critical.empty() && body.strikes.first() == nullptr &&
      row.values->next == nullptr) {
    return;
  }
  constexpr long double endless = std::numeric_limits<long double>::infinity();
  for (std::size_t offset = 0; offset < count;) {
    const std::uint64_t now = position_ + offset;
    std::uint64_t next = position_ + count;
    for (const StreamedChange* change = row.values->next; change != nullptr;
         change = row.values->next) {
      const long double at = change->time + body.readout.delays[r] * sample_rate_;
      const auto first = static_cast<std::uint64_t>(std::ceil(at));
      if (first > now) {
        next = std::min(next, first);
        break;
      }
      follow_strikes(body, r, now, at);
      change_row(body, r, now, at);
    }
    next = std::min(next, follow_strikes(body, r, now, endless));
    const auto stretch = static_cast<std::size_t>(next - now);
    render_stretch(body, r, now, offset, stretch);
    offset += stretch;
  }
}

/// Begins and ends contacts up to a sample, as far as they do so before a time.
/// @return the next sample at which one begins or ends
std::uint64_t StreamingRenderer::follow_strikes(Body& body, std::size_t r, std::uint64_t now,
                                                long double before) {
  Row& row = body.rows[r];
  std::uint64_t next = std::numeric_limits<std::uint64_t>::max();
  for (StreamedStrike* strike = body.strikes.first(); strike != nullptr; strike = strike->next) {
    StreamedStrike::InRow& in = strike->rows[r];
    if (in.ended) continue;
    const Resonances& resonances = row.values->resonances;
    if (!in.begun && in.first <= now && in.start < before) {
      in.begun = true;
      if (in.of != &resonances) answer(body, r, *strike);
      row.peak = 0;
      row.next_check = in.free + block_size;
      add_values(resonances, in.response.begin, row.voices);
    }
    if (in.begun && in.free <= now && in.stop < before) {
      add_values(resonances, in.response.end, row.voices);
      add_motions(resonances, in.response.near_critical, row.near_critical);
      in.ended = true;
      --strike->rows_left;
      continue;
    }
    next = std::min(next, in.begun ? in.free : in.first);
  }
  return next;
}

/// The row's modes have their next values; forces that act go on acting on them.
void StreamingRenderer::change_row(Body& body, std::size_t r, std::uint64_t now, long double at) {
  Row& row = body.rows[r];
  const Resonances& before = row.values->resonances;
  StreamedChange& change = *row.values->next;
  const auto index = static_cast<Eigen::Index>(r);
  const auto since =
      static_cast<double>(std::max(0.0L, static_cast<long double>(now) - at) / sample_rate_);
  find_motions(before, body.readout, index, row.voices, row.near_critical, since, change.motions);
  row.values = &change;
  for (StreamedStrike* strike = body.strikes.first(); strike != nullptr; strike = strike->next) {
    StreamedStrike::InRow& in = strike->rows[r];
    if (!in.begun) in.of = nullptr;
    if (!in.begun || in.ended) continue;
    const double t = std::clamp(static_cast<double>((at - in.start) / sample_rate_), 0.0,
                                strike->force.duration);
    add_contact_motions(before, strike->excitation, strike->force, t, 1, change.motions);
    add_contact_motions(change.resonances, strike->excitation, strike->force, t, -1,
                        change.motions);
    answer(body, r, *strike);
    in.response.forced.turning *=
        exponential(0, 2 * std::numbers::pi_v<long double> / strike->force.duration,
                    static_cast<long double>(now - in.first) / sample_rate_);
  }
  ring_from(change.resonances, body.readout, index, change.motions, since, change.rows[r].voices,
            change.rows[r].near_critical);
  std::swap(row.voices, change.rows[r].voices);
  std::swap(row.near_critical, change.rows[r].near_critical);
}

void StreamingRenderer::render_stretch(Body& body, std::size_t r, std::uint64_t begin,
                                       std::size_t offset, std::size_t count) {
  Row& row = body.rows[r];
  const Resonances& resonances = row.values->resonances;
  if (begin >= row.next_check) {
    row.next_check = begin + block_size;
    const std::size_t parts = resonances.rotations.size();
    drop_below(parts == 0 ? 0 : inaudible * row.peak / static_cast<double>(parts), row.voices);
    drop_gone(resonances, row.near_critical);
  }
  // Vectors may read a little beyond what is asked for.
  std::fill_n(block_.samples.begin(), std::min(block_size, count + 2 * max_lanes), 0.0);
  for (StreamedStrike* strike = body.strikes.first(); strike != nullptr; strike = strike->next) {
    StreamedStrike::InRow& in = strike->rows[r];
    if (!in.begun || in.ended) continue;
    const auto into = static_cast<std::size_t>(begin - in.first);
    ForcedMotion& forced = in.response.forced;
    for (std::size_t n = 0; n < count; ++n) {
      block_.samples[n] += in.response.direct[into + n] + forced.constant;
    }
    if (forced.turning != 0.0) {
      Voice turning = {&in.turn, forced.turning};
      add_voices({&turning, 1}, count, block_);
      move_on({&turning, 1}, count);
      forced.turning = turning.value;
    }
  }
  ring_on(resonances, row.near_critical, std::span(block_.samples).first(count));
  add_voices(row.voices, count, block_);
  move_on(row.voices, count);
  row.peak = std::max(row.peak, peak_of(block_, count));
  for (std::size_t n = 0; n < count; ++n) sum_.samples[offset + n] += block_.samples[n];
}

void StreamingRenderer::take_ended(Body& body) {
  StreamedStrike* before = nullptr;
  for (StreamedStrike* strike = body.strikes.first(); strike != nullptr;) {
    StreamedStrike* next = strike->next;
    if (strike->rows_left == 0) {
      ended_strikes_.push_back(body.strikes.take_after(before));
    } else {
      before = strike;
    }
    strike = next;
  }
  while (std::none_of(body.rows.begin(), body.rows.end(),
                      [&](const Row& row) { return row.values == body.values.first(); })) {
    ended_changes_.push_back(body.values.pop_front());
  }
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
