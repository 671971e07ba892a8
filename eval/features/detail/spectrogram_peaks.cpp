#include "eval/features/detail/spectrogram_peaks.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "core/numbers.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::eval::features {

namespace {

using Complex = std::complex<double>;

constexpr std::size_t shortest = 256, longest = 8192;
constexpr double peak_above_noise = 10;       ///< power ratio, 10 dB
constexpr double usual_min_decay_rate = 0.2;  ///< [1/s]
/// Bins on either side of a peak in which it is fitted, and from which it is taken.
constexpr int fitted_bins = 2, taken_bins = 8;

/// Power spectrogram of one window length: frames x bins, by hops of a quarter of the window.
struct Level {
  std::size_t length = 0;
  std::size_t hop = 0;
  Eigen::MatrixXd power;
  double noise = 0;  ///< median of the last fifth of the frames, as a mean
};

Level make_level(std::span<const double> samples, std::size_t length) {
  Level level{length, length / 4, {}, 0};
  const std::size_t frames = (samples.size() - length) / level.hop + 1;
  synth::signal::RealFft fft(length);
  level.power.resize(static_cast<Eigen::Index>(frames), static_cast<Eigen::Index>(fft.bins()));
  for (std::size_t m = 0; m < frames; ++m) {
    for (std::size_t n = 0; n < length; ++n) {
      const double w = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(n) /
                                            static_cast<double>(length));
      fft.signal()[n] = w * samples[m * level.hop + n];
    }
    fft.forward();
    for (std::size_t k = 0; k < fft.bins(); ++k) {
      level.power(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(k)) =
          std::norm(fft.spectrum()[k]);
    }
  }
  const auto tail = std::max<Eigen::Index>(1, level.power.rows() / 5);
  const Eigen::MatrixXd end = level.power.bottomRows(tail);
  std::vector<double> values(end.data(), end.data() + end.size());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  level.noise = *middle / std::numbers::ln2;
  return level;
}

/// A mode's parameters as they are fitted: per sample, amplitude in the logarithm.
struct Mode {
  double omega = 0;
  double decay = 0;
  double log_amplitude = 0;
};

/// Power of a mode in bin k of frame m: the window's transform of a damped sinusoid in closed form,
/// three geometric sums.
double model_power(const Level& level, const Mode& mode, double frame, double bin) {
  const auto n = static_cast<double>(level.length);
  const double step = 2 * std::numbers::pi / n;
  Complex sum = 0;
  for (int line = -1; line <= 1; ++line) {
    const Complex rate(-mode.decay, mode.omega - step * (bin + line));
    const Complex ratio = std::exp(rate);
    const Complex geometric =
        std::abs(ratio - 1.0) < 1e-12 ? Complex(n) : (std::exp(rate * n) - 1.0) / (ratio - 1.0);
    sum += (line == 0 ? 0.5 : -0.25) * geometric;
  }
  const double start = frame * static_cast<double>(level.hop);
  return 0.25 * std::norm(sum) * std::exp(2 * mode.log_amplitude - 2 * mode.decay * start);
}

struct Peak {
  std::size_t level = 0;
  Eigen::Index frame = 0;
  Eigen::Index bin = 0;
  double prominence = 0;  ///< power over the level's noise
};

/// Frames after a peak in which its bin stays above the noise.
Eigen::Index heard_frames(const Level& level, Eigen::Index frame, Eigen::Index bin) {
  Eigen::Index last = frame;
  while (last + 1 < level.power.rows() &&
         level.power(last + 1, bin) > peak_above_noise * level.noise) {
    ++last;
  }
  return last - frame + 1;
}

Mode first_guess(const Level& level, const Peak& peak, Eigen::Index frames) {
  const auto& power = level.power;
  const auto n = static_cast<double>(level.length);
  const auto log_at = [&](Eigen::Index k) { return std::log(power(peak.frame, k) + 1e-300); };
  const double left = log_at(peak.bin - 1), middle = log_at(peak.bin), right = log_at(peak.bin + 1);
  const double curve = left - 2 * middle + right;
  const double shift = curve < 0 ? std::clamp(0.5 * (left - right) / curve, -0.5, 0.5) : 0;
  Mode mode;
  mode.omega = 2 * std::numbers::pi * (static_cast<double>(peak.bin) + shift) / n;
  // Line through the logarithm of the peak's power over time.
  double mean_t = 0, mean_l = 0, tt = 0, tl = 0;
  for (Eigen::Index m = 0; m < frames; ++m) {
    mean_t += static_cast<double>(m);
    mean_l += std::log(power(peak.frame + m, peak.bin) + 1e-300);
  }
  mean_t /= static_cast<double>(frames);
  mean_l /= static_cast<double>(frames);
  for (Eigen::Index m = 0; m < frames; ++m) {
    const double t = static_cast<double>(m) - mean_t;
    tt += t * t;
    tl += t * (std::log(power(peak.frame + m, peak.bin) + 1e-300) - mean_l);
  }
  mode.decay = tt > 0 ? -0.5 * tl / tt / static_cast<double>(level.hop) : 2 / n;
  const double unit =
      model_power(level, mode, static_cast<double>(peak.frame), static_cast<double>(peak.bin));
  mode.log_amplitude = 0.5 * std::log(power(peak.frame, peak.bin) / std::max(unit, 1e-300));
  return mode;
}

/// Least squares on the power around a peak.
Mode fit_mode(const Level& level, const Peak& peak, Eigen::Index frames, Mode mode) {
  const Eigen::Index first = std::max<Eigen::Index>(0, peak.bin - fitted_bins);
  const Eigen::Index last = std::min(level.power.cols() - 1, peak.bin + fitted_bins);
  const Eigen::Index width = last - first + 1;
  const double scale = level.power(peak.frame, peak.bin);
  const auto misfit = [&](const Mode& candidate) {
    Eigen::VectorXd values(frames * width);
    for (Eigen::Index m = 0; m < frames; ++m) {
      for (Eigen::Index k = 0; k < width; ++k) {
        const double model = model_power(level, candidate, static_cast<double>(peak.frame + m),
                                         static_cast<double>(first + k));
        values(m * width + k) = (model - level.power(peak.frame + m, first + k)) / scale;
      }
    }
    return values;
  };
  const auto moved = [](Mode m, const Eigen::Vector3d& by) {
    return Mode{m.omega + by(0), m.decay + by(1), m.log_amplitude + by(2)};
  };
  const auto n = static_cast<double>(level.length);
  const Eigen::Vector3d step(1e-4 / n, 1e-4 / n, 1e-5);
  Eigen::VectorXd residual = misfit(mode);
  double damping = 1e-3;
  for (int round = 0; round < 20; ++round) {
    Eigen::MatrixXd jacobian(residual.size(), 3);
    for (int p = 0; p < 3; ++p) {
      Eigen::Vector3d by = Eigen::Vector3d::Zero();
      by(p) = step(p);
      jacobian.col(p) = (misfit(moved(mode, by)) - residual) / step(p);
    }
    Eigen::Matrix3d system = jacobian.transpose() * jacobian;
    system.diagonal() *= 1 + damping;
    const Eigen::Vector3d by = -system.ldlt().solve(jacobian.transpose() * residual);
    if (!by.allFinite()) break;
    const Mode candidate = moved(mode, by);
    const Eigen::VectorXd next = misfit(candidate);
    if (next.squaredNorm() < residual.squaredNorm()) {
      const double fallen = 1 - next.squaredNorm() / residual.squaredNorm();
      mode = candidate;
      residual = next;
      damping *= 0.2;
      if (fallen < 1e-6) break;
    } else {
      damping = 10 * damping;
      if (damping > 1e6) break;
    }
  }
  return mode;
}

/// Takes a mode's power out of a spectrogram; @return what was taken
double take_out(Level& level, const Mode& mode) {
  const auto centre = static_cast<Eigen::Index>(
      std::llround(mode.omega * static_cast<double>(level.length) / (2 * std::numbers::pi)));
  double taken = 0;
  for (Eigen::Index k = std::max<Eigen::Index>(0, centre - taken_bins);
       k <= std::min(level.power.cols() - 1, centre + taken_bins); ++k) {
    for (Eigen::Index m = 0; m < level.power.rows(); ++m) {
      const double part =
          std::min(level.power(m, k),
                   model_power(level, mode, static_cast<double>(m), static_cast<double>(k)));
      level.power(m, k) -= part;
      taken += part;
    }
  }
  return taken;
}

Peak highest(const std::vector<Level>& levels, double sample_rate, const FeatureOptions& options) {
  Peak best;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const Level& level = levels[l];
    const double bin = sample_rate / static_cast<double>(level.length);
    const auto first = std::max<Eigen::Index>(
        2, static_cast<Eigen::Index>(std::ceil(options.min_frequency / bin)));
    const auto last =
        std::min(level.power.cols() - 2, static_cast<Eigen::Index>(options.max_frequency / bin));
    for (Eigen::Index k = first; k < last; ++k) {
      for (Eigen::Index m = 0; m < level.power.rows(); ++m) {
        const double prominence = level.power(m, k) / std::max(level.noise, 1e-300);
        if (prominence > best.prominence) best = {l, m, k, prominence};
      }
    }
  }
  return best;
}

}  // namespace

void by_peaks(std::span<const double> samples, double sample_rate, double after_onset,
              const FeatureOptions& options, FeatureSet& set) {
  set.residual.assign(samples.begin(), samples.end());
  std::vector<Level> levels;
  for (std::size_t length = shortest; length <= longest && 2 * length <= samples.size();
       length *= 2) {
    levels.push_back(make_level(samples, length));
  }
  if (levels.empty()) return;
  // A noise floor of nothing would make every rounding a peak.
  for (Level& level : levels) level.noise = std::max(level.noise, 1e-12 * level.power.maxCoeff());
  const double all = levels.back().power.sum();
  double explained = 0;
  for (std::size_t round = 0; round < 4 * options.max_features; ++round) {
    const Peak peak = highest(levels, sample_rate, options);
    if (peak.prominence < peak_above_noise || set.features.size() >= options.max_features ||
        explained > options.explained * all) {
      break;
    }
    Level& level = levels[peak.level];
    const Eigen::Index frames = heard_frames(level, peak.frame, peak.bin);
    Mode mode = first_guess(level, peak, frames);
    if (frames >= 3) mode = fit_mode(level, peak, frames, mode);
    const double before = level.power(peak.frame, peak.bin);
    const double decay_rate = mode.decay * sample_rate;
    const double frequency = mode.omega * sample_rate / (2 * std::numbers::pi);
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const double taken = take_out(levels[l], mode);
      if (l + 1 == levels.size()) explained += taken;
    }
    // What a fit did not reach is not looked at again.
    if (level.power(peak.frame, peak.bin) > 0.5 * before) {
      level.power(peak.frame, peak.bin) = 0;
      continue;
    }
    if (frames < 3 || !(frequency > options.min_frequency) ||
        !(frequency < options.max_frequency) || !(decay_rate < 2000)) {
      continue;
    }
    const double amplitude = std::exp(mode.log_amplitude);
    if (decay_rate < options.min_decay_rate.value_or(usual_min_decay_rate)) {
      set.hums.push_back({frequency, decay_rate, amplitude});
      continue;
    }
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    Feature feature;
    feature.frequency = frequency;
    feature.decay_rate = decay_rate;
    feature.amplitude = amplitude * std::exp(mode.decay * after_onset);
    feature.phase = feature.frequency_error = feature.decay_rate_error = feature.amplitude_error =
        unknown;
    feature.snr = core::decibels(peak.prominence);
    set.features.push_back(feature);
  }
  set.explained = all > 0 ? std::min(1.0, explained / all) : 0;
}

}  // namespace carillon::eval::features
