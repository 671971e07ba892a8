#include "synth/modal/thrift.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "synth/modal/heard_modes.hpp"
#include "synth/modal/hearing.hpp"
#include "synth/modal/mode_norms.hpp"
#include "synth/modal/row_response.hpp"

namespace carillon::synth::modal {

namespace {

constexpr double kReferencePressure = 20e-6;  ///< [Pa]
constexpr std::size_t kMaskers = 64;
constexpr std::size_t kGroup = 64;  ///< modes whose products are all taken
/// Samples of contacts that are looked at; longer ones are not worth it.
constexpr std::size_t kContactSamples = 4'000'000;

double level(double mean_square) {
  return 10 * std::log10(mean_square);
}

enum class Verdict { heard, soft, masked };

/// Which modes cannot be heard in one row. Powers are relative to the square of `reference`.
std::vector<Verdict> judge_row(const std::vector<RingingMode>& modes, std::vector<HeardMode>& heard,
                               const RowTimes& times, double duration, double sample_rate,
                               bool calibrated, const ThriftOptions& options) {
  std::vector<Verdict> verdicts(modes.size(), Verdict::heard);
  std::vector<std::size_t> order;
  double loudest = 0;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (modes[i].kind != MotionKind::ringing) continue;
    order.push_back(i);
    loudest = std::max(loudest, heard[i].loudness);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::norm(heard[a].amplitude) > std::norm(heard[b].amplitude);
  });
  const double reference = calibrated    ? kReferencePressure * kReferencePressure
                           : loudest > 0 ? loudest
                                         : 1;
  struct Masker {
    double bark, level, decay_rate;
  };
  std::vector<Masker> maskers;
  for (const std::size_t i : order) {
    const RingingMode& mode = modes[i];
    HeardMode& here = heard[i];
    const double quiet =
        calibrated ? hearing_threshold(mode.frequency) - options.margin : -options.range;
    const double hidden_below = [&] {
      double power = 0;
      for (const Masker& masker : maskers) {
        if (masker.decay_rate > -mode.pole.real()) continue;
        power += std::pow(10, (masker.level + spreading(mode.bark - masker.bark)) / 10);
      }
      return level(power) - options.margin;
    }();
    const double start = level(std::norm(here.amplitude) / 2 / reference);
    const bool maybe_soft = level(here.loudness / reference) < quiet;
    bool soft = maybe_soft, masked = start < hidden_below;
    if (soft || masked) {
      // The forced motion, which the loudness above does not know.
      hear_contact(mode, times, duration, sample_rate, here);
      const double contact = here.contact_energy / (sample_rate * kIntegrationTime);
      soft = soft && level((here.loudness + contact) / reference) < quiet;
      masked =
          masked && level(here.contact_peak * here.contact_peak / 2 / reference) < hidden_below;
    }
    if (soft || masked) {
      verdicts[i] = soft ? Verdict::soft : Verdict::masked;
    } else if (maskers.size() < kMaskers && std::isfinite(start)) {
      maskers.push_back({mode.bark, start - masking_offset(mode.bark), -mode.pole.real()});
    }
  }
  return verdicts;
}

/// Integral of the force's magnitude.
double total_force(const ContactForce& force) {
  if (force.samples.empty()) return 1;
  double sum = 0;
  for (std::size_t k = 1; k < force.samples.size(); ++k) {
    sum += std::max(std::abs(force.samples[k - 1]), std::abs(force.samples[k]));
  }
  return sum * force.duration / static_cast<double>(force.samples.size() - 1);
}

/// No smaller than the L2 norm after the contact of a mode that is no partial.
double norm_of_other(const RingingMode& mode, const Weights& weights, const RowTimes& times,
                     double sample_rate, std::size_t free) {
  // The bound falls with time: each block of doubling length is at most its first value.
  double square = 0;
  for (std::size_t n = 0, width = 1; n < free; n += width, width *= 2) {
    const double time = times.offset + static_cast<double>(n) / sample_rate;
    const double bound = mode.pulse->bound_after_contact(time, weights);
    square += bound * bound * static_cast<double>(std::min(width, free - n));
  }
  return std::sqrt(square);
}

/// No smaller than the L2 norm of a sum of partials. All products of a thousand modes cost more
/// than their sound: exact within groups, the loudest together, and the groups' norms add up.
double norm_from_above(std::vector<SampledPartial> partials, std::size_t count) {
  std::sort(partials.begin(), partials.end(), [](const auto& a, const auto& b) {
    return std::norm(a.amplitude) > std::norm(b.amplitude);
  });
  double sum = 0;
  for (std::size_t i = 0; i < partials.size(); i += kGroup) {
    sum += norm_of_sum(std::span(partials).subspan(i, std::min(kGroup, partials.size() - i)), count)
               .high;
  }
  return sum;
}

/// Bound of the missing modes' norm over the full row's.
double row_error(const std::vector<RingingMode>& modes, std::vector<HeardMode>& heard,
                 const std::vector<bool>& left_out, const RowTimes& times,
                 const ContactForce& force, double sample_rate, std::size_t count) {
  constexpr double kUnbounded = std::numeric_limits<double>::infinity();
  const std::size_t free = count - times.free;
  std::vector<double> contact(times.free - times.first, 0.0);  // of what is missing
  std::vector<SampledPartial> missing, kept;
  bool all_ring = true;
  double unknown = 0;  // kept, but not a partial
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const RingingMode& mode = modes[i];
    if (mode.kind == MotionKind::above_band || !heard[i].weights.any()) continue;
    if (mode.kind == MotionKind::other) {
      all_ring = false;
      // A mode without stiffness and damping never ends.
      unknown += mode.drifts ? kUnbounded
                             : total_force(force) *
                                   norm_of_other(mode, heard[i].weights, times, sample_rate, free);
      continue;
    }
    (left_out[i] ? missing : kept).push_back(partial_of(mode, heard[i], times, sample_rate));
    if (!left_out[i]) continue;
    hear_contact(mode, times, force.duration, sample_rate, heard[i]);
    for (std::size_t n = 0; n < contact.size(); ++n) contact[n] += heard[i].contact[n];
  }
  if (missing.empty()) return 0;
  if (kept.empty() && all_ring) return 1;  // all of it is missing
  double during = 0;
  for (const double value : contact) during += value * value;
  const double after = norm_from_above(std::move(missing), free);
  const double error = std::sqrt(during + after * after);
  if (error == 0) return 0;
  const double whole = norm_of_sum(kept, free).low - unknown - after;
  return whole > 0 ? error / whole : kUnbounded;
}

void erase_columns(Eigen::MatrixXd& gains, const std::vector<Eigen::Index>& kept) {
  if (gains.size() != 0) gains = gains(Eigen::all, kept).eval();
}

void erase(RingDown& rings, const std::vector<bool>& left_out) {
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < left_out.size(); ++i) {
    if (left_out[i]) continue;
    rings.eigenvalues[kept.size()] = rings.eigenvalues[i];
    rings.decay_rates[kept.size()] = rings.decay_rates[i];
    kept.push_back(static_cast<Eigen::Index>(i));
  }
  rings.eigenvalues.resize(kept.size());
  rings.decay_rates.resize(kept.size());
  rings.excitation = rings.excitation(kept).eval();
  for (Eigen::MatrixXd* gains : gains_of(rings.readout)) erase_columns(*gains, kept);
}

}  // namespace

ThriftReport leave_out_inaudible(RingDown& rings, const ContactForce& force, double sample_rate,
                                 std::size_t count, const ThriftOptions& options) {
  for (const double value : {options.margin, options.range}) {
    if (!(value >= 0) || !std::isfinite(value)) {
      throw core::InputError(
          fmt::format("thrift: margin and range must not be negative, not {} dB", value));
    }
  }
  const Readout& readout = rings.readout;
  const bool calibrated = readout.unit == "Pa";
  const std::size_t rows = readout.delays.size();
  const std::vector<RingingMode> modes = ringing_modes(rings, force, sample_rate);

  std::vector<RowTimes> times;
  std::size_t contact_samples = 0;
  std::vector<std::vector<HeardMode>> heard(rows);
  std::vector<bool> left_out(modes.size());
  std::vector<bool> masked(modes.size());
  for (std::size_t i = 0; i < modes.size(); ++i) left_out[i] = modes[i].kind == MotionKind::ringing;
  for (std::size_t r = 0; r < rows; ++r) {
    times.push_back(row_times(readout.delays[r], force, sample_rate, count));
    contact_samples += (times[r].free - times[r].first) * modes.size();
  }
  if (contact_samples > kContactSamples) return {};
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t i = 0; i < modes.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      heard[r].push_back(hear_mode(
          modes[i],
          weights_of(readout, static_cast<Eigen::Index>(r), column, rings.excitation[column]),
          force.duration));
    }
    const auto verdicts =
        judge_row(modes, heard[r], times[r], force.duration, sample_rate, calibrated, options);
    for (std::size_t i = 0; i < modes.size(); ++i) {
      left_out[i] = left_out[i] && verdicts[i] != Verdict::heard;
      masked[i] = masked[i] || verdicts[i] == Verdict::masked;
    }
  }

  ThriftReport report;
  for (std::size_t r = 0; r < rows; ++r) {
    report.error_bound = std::max(report.error_bound, row_error(modes, heard[r], left_out, times[r],
                                                                force, sample_rate, count));
  }
  if (!std::isfinite(report.error_bound)) return {};
  for (std::size_t i = 0; i < modes.size(); ++i) {
    report.left_out += left_out[i] ? 1 : 0;
    report.masked += left_out[i] && masked[i] ? 1 : 0;
  }
  if (report.left_out > 0) erase(rings, left_out);
  return report;
}

double decibels(double error_bound) {
  return error_bound > 1e-15 ? 20 * std::log10(error_bound) : -300;
}

}  // namespace carillon::synth::modal
