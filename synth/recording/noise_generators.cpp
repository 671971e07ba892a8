#include "synth/recording/noise_generators.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"
#include "core/units.hpp"

namespace carillon::synth::recording {

namespace {

constexpr double pi = std::numbers::pi;

/// Turns the slope of a discrete integrator of order one half, |2 sin(w/2)|^(-1/2), into w^(-1/2)
/// up to 0.05 dB below 0.9 of half the rate; one zero and one pole fitted to sqrt(2 sin(w/2) / w).
/// Its memory of 0.2^n is over after a few samples.
void straighten(std::vector<double>& samples) {
  constexpr double zero = 0.30086362;
  constexpr double pole = 0.2125968;
  constexpr double scale = (1 + pole) / (1 + zero);
  double in = 0;
  double out = 0;
  for (double& sample : samples) {
    out = scale * (sample + zero * in) - pole * out;
    in = sample;
    sample = out;
  }
}

/// Samples that come before the first one that is kept, so that short filters have settled.
constexpr std::size_t settling_samples = 32;

std::vector<double> white(std::size_t count, core::RandomStream& random) {
  std::vector<double> samples(count);
  random.normals(samples);
  return samples;
}

/// First-order filters side by side, driven by one noise: sum over k of gain_k / (1 - pole_k z^-1).
struct PoleSum {
  Eigen::ArrayXd poles;
  Eigen::ArrayXd gains;
  double direct = 0;
};

/// (1 - z^-1)^(-1/2) = 1/pi int_0^1 x^(-1/2) (1-x)^(-1/2) / (1 - x z^-1) dx, by the trapezoidal
/// rule in u where x = 1 / (1 + e^-u): the error is below 2 exp(-pi^2 / step) = 0.005 dB. Slower
/// poles than `corner` [rad] are gathered in the last one; poles near 0 in the direct path.
PoleSum half_integrator(double corner) {
  constexpr double step = 1.2;
  constexpr double fast = -3;
  constexpr double negligible = 80;
  PoleSum sum;
  std::vector<double> poles, gains;
  const auto weight = [&](double u) { return step / pi / (2 * std::cosh(u / 2)); };
  const double slow = std::log(1 / corner);
  double u = slow;
  for (; u >= fast; u -= step) {
    poles.push_back(1 / (1 + std::exp(-u)));
    gains.push_back(weight(u));
  }
  for (; u > -negligible; u -= step) sum.direct += weight(u);
  for (u = slow + step; u < negligible; u += step) gains.front() += weight(u);
  sum.poles = Eigen::Map<Eigen::ArrayXd>(poles.data(), static_cast<Eigen::Index>(poles.size()));
  sum.gains = Eigen::Map<Eigen::ArrayXd>(gains.data(), static_cast<Eigen::Index>(gains.size()));
  return sum;
}

/// States of the filters in the middle of a noise: normal with covariance
/// gain_k gain_l / (1 - pole_k pole_l).
Eigen::ArrayXd stationary_state(const PoleSum& filter, core::RandomStream& random) {
  const Eigen::VectorXd p = filter.poles.matrix();
  const Eigen::VectorXd g = filter.gains.matrix();
  const Eigen::MatrixXd covariance =
      ((g * g.transpose()).array() / (1 - (p * p.transpose()).array())).matrix();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance);
  Eigen::VectorXd normal(p.size());
  random.normals({normal.data(), static_cast<std::size_t>(normal.size())});
  const Eigen::VectorXd spread = axes.eigenvalues().cwiseMax(0).cwiseSqrt();
  return (axes.eigenvectors() * spread.cwiseProduct(normal)).array();
}

std::vector<double> pink(std::size_t count, double sample_rate, core::RandomStream& random) {
  const PoleSum filter = half_integrator(2 * pi * 2 / sample_rate);
  Eigen::ArrayXd state = stationary_state(filter, random);
  std::vector<double> samples = white(count + settling_samples, random);
  for (double& sample : samples) {
    state = filter.poles * state + filter.gains * sample;
    sample = state.sum() + filter.direct * sample;
  }
  straighten(samples);
  return samples;
}

std::vector<double> brown(std::size_t count, double sample_rate, core::RandomStream& random) {
  const double pole = std::exp(-2 * pi * 5 / sample_rate);
  std::vector<double> samples = white(count + settling_samples, random);
  double state = samples.front() / std::sqrt(1 - pole * pole);
  for (double& sample : samples) {
    state = pole * state + sample;
    sample = state;
  }
  straighten(samples);
  straighten(samples);
  return samples;
}

/// Fundamental of the mains [Hz]; a grid's frequency wanders by some hundredths of a hertz.
double mains_frequency(core::RandomStream& random) {
  const double mains = random.uniform() < 0.5 ? 50 : 60;
  return mains + 0.05 * random.normal();
}

/// Block by block as a matrix product: e^{i h w (n + block)} = e^{i h w n} e^{i h w block}.
std::vector<double> hum(double frequency, std::size_t count, double sample_rate,
                        core::RandomStream& random) {
  std::vector<double> rates;
  std::vector<std::complex<double>> amplitudes;
  for (int h = 1; h <= 20 && h * frequency < 0.45 * sample_rate; ++h) {
    const double level = std::pow(10.0, 6 * random.normal() / 20) / h;
    rates.push_back(2 * pi * h * frequency / sample_rate);
    amplitudes.push_back(std::polar(level, random.uniform(0, 2 * pi)));
  }
  const std::size_t block = 256;
  const std::size_t blocks = (count + block - 1) / block;
  const auto harmonics = static_cast<Eigen::Index>(rates.size());
  Eigen::MatrixXd within(static_cast<Eigen::Index>(block), 2 * harmonics);
  Eigen::MatrixXd begins(2 * harmonics, static_cast<Eigen::Index>(blocks));
  for (Eigen::Index h = 0; h < harmonics; ++h) {
    const auto at = static_cast<std::size_t>(h);
    for (Eigen::Index n = 0; n < within.rows(); ++n) {
      const auto turn = std::polar(1.0, rates[at] * static_cast<double>(n));
      within(n, 2 * h) = turn.real();
      within(n, 2 * h + 1) = -turn.imag();
    }
    for (Eigen::Index b = 0; b < begins.cols(); ++b) {
      const auto start =
          amplitudes[at] * std::polar(1.0, rates[at] * static_cast<double>(b * within.rows()));
      begins(2 * h, b) = start.real();
      begins(2 * h + 1, b) = start.imag();
    }
  }
  double power = 0;
  for (const auto& amplitude : amplitudes) power += std::norm(amplitude) / 2;
  const Eigen::MatrixXd sum = within * begins / std::sqrt(power);
  return {sum.data(), sum.data() + count};
}

/// Second-order low or high pass of Butterworth's (bilinear transform), for `speech_shape`.
struct Biquad {
  double b0, b1, b2, a1, a2;
  Biquad(double cutoff, double sample_rate, bool low) {
    const double k = std::tan(pi * cutoff / sample_rate);
    const double norm = 1 / (1 + std::numbers::sqrt2 * k + k * k);
    b0 = b2 = (low ? k * k : 1) * norm;
    b1 = (low ? 2 : -2) * b0;
    a1 = 2 * (k * k - 1) * norm;
    a2 = (1 - std::numbers::sqrt2 * k + k * k) * norm;
  }
  void filter(std::vector<double>& samples) const {
    double first = 0;
    double second = 0;
    for (double& sample : samples) {
      const double in = sample;
      sample = b0 * in + first;
      first = b1 * in - a1 * sample + second;
      second = b2 * in - a2 * sample;
    }
  }
};

/// Masking noise of speech audiometers (IEC 60645-1): even from 0.1 to 1 kHz, -12 dB per octave
/// above.
std::vector<double> babble(std::size_t count, double sample_rate, core::RandomStream& random) {
  const double top = std::min(1000.0, 0.4 * sample_rate);
  // The high pass of 100 Hz has forgotten its beginning after 20 ms.
  const auto settle = static_cast<std::size_t>(0.02 * sample_rate);
  std::vector<double> samples = white(count + settle, random);
  // Syllables are slow: their envelope is made at 1 to 2 kHz and is straight between its values.
  const auto step = static_cast<std::size_t>(sample_rate / 1000);
  const auto envelope = babble_envelope(babble_talkers, samples.size() / step + 2,
                                        sample_rate / static_cast<double>(step), random);
  for (std::size_t begin = 0, k = 0; begin < samples.size(); begin += step, ++k) {
    const double slope = (envelope[k + 1] - envelope[k]) / static_cast<double>(step);
    for (std::size_t i = begin; i < std::min(begin + step, samples.size()); ++i) {
      samples[i] *= envelope[k] + slope * static_cast<double>(i - begin);
    }
  }
  Biquad(top, sample_rate, true).filter(samples);
  Biquad(100, sample_rate, false).filter(samples);
  return samples;
}

void check_rate(double sample_rate) {
  if (!(sample_rate >= 1e3 && sample_rate <= 1e7)) {
    throw core::InputError(
        fmt::format("noise at {} Hz: the rate must lie between 1 kHz and 10 MHz", sample_rate));
  }
}

}  // namespace

const std::vector<std::string>& noise_kind_names() {
  static const std::vector<std::string> names = {"white", "pink", "brown", "hum", "babble"};
  return names;
}

const std::vector<std::string>& noise_kind_spectra() {
  static const std::vector<std::string> spectra = {
      "even", "-3 dB per octave", "-6 dB per octave from 20 Hz up, even below 5 Hz",
      "mains: 50 or 60 Hz and 19 harmonics with random phases and levels",
      "voices without words: even from 0.1 to 1 kHz, -12 dB per octave above; syllables of six "
      "talkers"};
  return spectra;
}

NoiseKind noise_kind(const std::string& name) {
  const auto& names = noise_kind_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    const std::string near = core::nearest_name(name, names);
    throw core::InputError(
        fmt::format("\"{}\" is no kind of noise{}", name,
                    near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)),
        fmt::format("kinds: {}", fmt::join(names, ", ")));
  }
  return static_cast<NoiseKind>(found - names.begin());
}

std::vector<double> babble_envelope(int talkers, std::size_t count, double sample_rate,
                                    core::RandomStream& random) {
  std::vector<double> power(count, 0.0);
  // Mean square of a syllable's raised cosine is 3/8; of levels 4 dB apart exp((ln10/10 4)^2 / 2).
  const double spread = std::log(10.0) / 10 * 4;
  const double mean = 0.8 * 3.0 / 8 * std::exp(spread * spread / 2);
  const auto end = static_cast<double>(count);
  for (int talker = 0; talker < talkers; ++talker) {
    // A talker is met somewhere in a syllable; the first ones are over before the clip begins.
    double begin = -(1 + random.uniform()) * 0.35 * sample_rate;
    while (begin < end) {
      const double length = random.uniform(0.12, 0.35) * sample_rate;
      const double level = std::exp(spread * random.normal());
      const bool pause = random.uniform() < 0.2;
      const auto first = static_cast<std::size_t>(std::max(0.0, std::ceil(begin)));
      const auto last = static_cast<std::size_t>(std::clamp(std::ceil(begin + length), 0.0, end));
      if (!pause && first < last) {
        // cos by recurrence: a syllable is too short for its rounding to grow.
        const double turn = 2 * pi / length;
        const double twice = 2 * std::cos(turn);
        double now = std::cos(turn * (static_cast<double>(first) - begin));
        double before = std::cos(turn * (static_cast<double>(first) - begin - 1));
        for (std::size_t i = first; i < last; ++i) {
          const double shape = 0.5 - 0.5 * now;
          power[i] += level * shape * shape;
          const double next = twice * now - before;
          before = now;
          now = next;
        }
      }
      begin += length;
    }
  }
  for (double& value : power) value = std::sqrt(value / (mean * talkers));
  return power;
}

std::vector<double> generate_noise(NoiseKind kind, std::size_t count, double sample_rate,
                                   core::RandomStream& random) {
  check_rate(sample_rate);
  std::vector<double> samples;
  switch (kind) {
    case NoiseKind::white:
      return white(count, random);
    case NoiseKind::pink:
      samples = pink(count, sample_rate, random);
      break;
    case NoiseKind::brown:
      samples = brown(count, sample_rate, random);
      break;
    case NoiseKind::hum:
      return hum(mains_frequency(random), count, sample_rate, random);
    case NoiseKind::babble:
      samples = babble(count, sample_rate, random);
      break;
  }
  // What came while filters settled is left out.
  samples.erase(samples.begin(), samples.end() - static_cast<std::ptrdiff_t>(count));
  return samples;
}

std::vector<double> generate_rows(NoiseKind kind, std::size_t count, std::size_t rows,
                                  double sample_rate, core::RandomStream& random) {
  std::vector<double> samples;
  samples.reserve(rows * count);
  check_rate(sample_rate);
  const double mains = kind == NoiseKind::hum ? mains_frequency(random) : 0;
  for (std::size_t row = 0; row < rows; ++row) {
    const auto one = kind == NoiseKind::hum ? hum(mains, count, sample_rate, random)
                                            : generate_noise(kind, count, sample_rate, random);
    samples.insert(samples.end(), one.begin(), one.end());
  }
  return samples;
}

}  // namespace carillon::synth::recording
