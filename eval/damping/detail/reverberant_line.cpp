#include "eval/damping/detail/reverberant_line.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/numbers.hpp"
#include "eval/damping/detail/bounded_newton.hpp"
#include "eval/damping/detail/jet.hpp"

namespace carillon::eval::damping {

namespace {

using Complex = std::complex<double>;
using LineJet = Jet<4>;
enum LinePlace { line_omega, line_decay, line_drive, line_noise };

constexpr int filter_reach = 4;  // samples of the band
constexpr double filter_roll_off = 0.6;
constexpr std::size_t min_samples = 12;
constexpr double steady_decay = 1e-5;  // lower bound of d over the least that is told

/// Root-raised-cosine pulse, its symbols 1 apart.
double root_raised_cosine(double t) {
  constexpr double pi = std::numbers::pi, b = filter_roll_off;
  if (std::abs(t) < 1e-9) return 1 - b + 4 * b / pi;
  const double rest = 1 - std::pow(4 * b * t, 2);
  if (std::abs(rest) < 1e-9) {
    return b / std::numbers::sqrt2 *
           ((1 + 2 / pi) * std::sin(pi / (4 * b)) + (1 - 2 / pi) * std::cos(pi / (4 * b)));
  }
  return (std::sin(pi * t * (1 - b)) + 4 * b * t * std::cos(pi * t * (1 + b))) / (pi * t * rest);
}

struct ComplexJet {
  LineJet re, im;
};
ComplexJet operator*(const ComplexJet& a, const ComplexJet& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

LineJet cos_of(const LineJet& x) {
  return chained(x, std::cos(x.value), -std::sin(x.value), -std::cos(x.value));
}
LineJet sin_of(const LineJet& x) {
  return chained(x, std::sin(x.value), std::cos(x.value), -std::sin(x.value));
}
LineJet inverse_of(const LineJet& x) {
  const double f = 1 / x.value;
  return chained(x, f, -f * f, 2 * f * f * f);
}

/// (1 - exp(-x)) / x
LineJet mean_decay(const LineJet& x) {
  const double v = x.value;
  if (std::abs(v) < 0.02) {
    return chained(x, 1 - v * (1.0 / 2 - v * (1.0 / 6 - v * (1.0 / 24 - v / 120))),
                   -1.0 / 2 + v * (1.0 / 3 - v * (1.0 / 8 - v / 30)),
                   1.0 / 3 - v * (1.0 / 4 - v / 10));
  }
  const double f = -std::expm1(-v) / v;
  const double slope = (std::exp(-v) - f) / v;
  return chained(x, f, slope, (-std::exp(-v) - 2 * slope) / v);
}

/// Innovations and their variances, told one by one.
template <class Tell>
void filter(const BandSignal& band, double room_rate, std::span<const double, 4> at, Tell tell) {
  const double step = 1 / band.rate;
  const LineJet d = exp(LineJet::variable(at[line_decay], line_decay));
  const LineJet noise = exp(LineJet::variable(at[line_noise], line_noise));
  const LineJet angle = step * LineJet::variable(at[line_omega], line_omega);
  const LineJet size = exp(-step * d);
  const ComplexJet turn{size * cos_of(angle), size * sin_of(angle)};
  const LineJet loss = size * size;
  const LineJet drive = exp(LineJet::variable(at[line_drive], line_drive)) *
                        (step * std::exp(-2 * room_rate * step) *
                         mean_decay(2 * step * (d - LineJet::constant(room_rate))));
  const Complex first = band.samples.front();
  ComplexJet state{LineJet::constant(first.real()), LineJet::constant(first.imag())};
  LineJet variance = noise;
  for (std::size_t n = 1; n < band.samples.size(); ++n) {
    const double decayed =
        std::exp(-2 * room_rate * (band.begin + static_cast<double>(n - 1) * step));
    state = turn * state;
    variance = loss * variance + decayed * drive;
    const ComplexJet innovation{LineJet::constant(band.samples[n].real()) - state.re,
                                LineJet::constant(band.samples[n].imag()) - state.im};
    const LineJet total = variance + noise;
    tell(innovation, total);
    const LineJet gain = variance * inverse_of(total);
    state.re = state.re + gain * innovation.re;
    state.im = state.im + gain * innovation.im;
    variance = gain * noise;
  }
}

LineJet misfit_jet(const BandSignal& band, double room_rate, std::span<const double, 4> at) {
  LineJet sum;
  filter(band, room_rate, at, [&](const ComplexJet& innovation, const LineJet& variance) {
    const LineJet power = innovation.re * innovation.re + innovation.im * innovation.im;
    sum = sum + log(variance) + power * inverse_of(variance);
  });
  return sum;
}

double whiteness_of(const BandSignal& band, double room_rate, std::span<const double, 4> at) {
  std::vector<Complex> white;
  filter(band, room_rate, at, [&](const ComplexJet& innovation, const LineJet& variance) {
    white.push_back(Complex(innovation.re.value, innovation.im.value) / std::sqrt(variance.value));
  });
  double power = 0, correlated = 0;
  for (const Complex& value : white) power += std::norm(value);
  for (std::size_t lag = 1; lag <= 3; ++lag) {
    Complex sum = 0;
    for (std::size_t n = lag; n < white.size(); ++n) sum += white[n] * std::conj(white[n - lag]);
    correlated += std::norm(sum);
  }
  return correlated * static_cast<double>(white.size()) / (power * power);
}

}  // namespace

BandSignal band_signal(std::span<const double> sound, double sample_rate, double frequency,
                       double rate) {
  const auto every = static_cast<std::size_t>(std::max(1.0, std::round(sample_rate / rate)));
  const std::size_t reach = filter_reach * every;
  BandSignal band{frequency,
                  sample_rate / static_cast<double>(every),
                  static_cast<double>(reach) / sample_rate,
                  {}};
  std::vector<Complex> taps(2 * reach + 1);
  double energy = 0;
  for (std::size_t k = 0; k < taps.size(); ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(every) - filter_reach;
    const double window = 0.5 + 0.5 * std::cos(std::numbers::pi * t / (filter_reach + 0.25));
    const double tap = window * root_raised_cosine(t);
    energy += tap * tap;
    taps[k] =
        std::polar(tap, -2 * std::numbers::pi * frequency * static_cast<double>(k) / sample_rate);
  }
  for (std::size_t first = 0; first + taps.size() <= sound.size(); first += every) {
    Complex sum = 0;
    for (std::size_t k = 0; k < taps.size(); ++k) sum += taps[k] * sound[first + k];
    const double turn = std::remainder(frequency * static_cast<double>(first) / sample_rate, 1.0);
    band.samples.push_back(sum * std::polar(1 / std::sqrt(energy), -2 * std::numbers::pi * turn));
  }
  return band;
}

double line_misfit(const BandSignal& band, double room_rate, std::span<const double, 4> at) {
  return misfit_jet(band, room_rate, at).value;
}

std::optional<ReverberantLine> fit_line(const BandSignal& band, double room_rate) {
  const std::size_t count = band.samples.size();
  if (count < min_samples) return {};
  double peak = 0;
  std::vector<double> late;
  for (std::size_t n = 0; n < count; ++n) {
    peak = std::max(peak, std::norm(band.samples[n]));
    if (n >= count - count / 5) late.push_back(std::norm(band.samples[n]));
  }
  if (!(peak > 0)) return {};
  const double noise = std::max(core::median(late) / std::numbers::ln2, 1e-12 * peak);
  const double fastest = 2 * band.rate, widest = 0.3 * 2 * std::numbers::pi * band.rate;
  const double told = told_decay * band.rate / static_cast<double>(count);
  const double slowest = steady_decay * std::min(told, room_rate);
  Box box{
      Eigen::Vector4d(-widest, std::log(slowest), std::log(1e-3 * peak), std::log(1e-13 * peak)),
      Eigen::Vector4d(widest, std::log(fastest), std::log(1e8 * peak), std::log(peak))};
  const Objective objective = [&](const Eigen::VectorXd& x) {
    const LineJet jet = misfit_jet(band, room_rate, std::span<const double, 4>(x.data(), 4));
    return LocalModel{jet.value, jet.first, jet.second};
  };
  BoundedMinimum best;
  best.at.value = core::infinity;
  for (const double decay : {0.03, 0.4, 1.2, 3.0}) {
    const Eigen::Vector4d start(0, std::log(decay * room_rate), std::log(40 * peak),
                                std::log(noise));
    NewtonOptions options;
    options.tolerance = 1e-7;
    options.max_iterations = 100;
    BoundedMinimum found = minimise(objective, start, box, options);
    if (found.at.value < best.at.value) best = std::move(found);
  }
  if (!best.converged) return {};
  // At a bound of its frequency or the upper one of its decay it is no mode.
  if (best.x[line_decay] >= box.high[line_decay] || std::abs(best.x[line_omega]) >= widest) {
    return {};
  }
  ReverberantLine line;
  line.frequency = band.frequency + best.x[line_omega] / (2 * std::numbers::pi);
  line.decay_rate = std::exp(best.x[line_decay]);
  line.level = peak / std::exp(best.x[line_noise]);
  line.whiteness = whiteness_of(band, room_rate, std::span<const double, 4>(best.x.data(), 4));
  line.too_slow = line.decay_rate < told;
  if (line.too_slow) {
    line.frequency_error = line.decay_rate_error = core::infinity;
    return line;
  }
  std::vector<Eigen::Index> free = {line_omega, line_decay};
  for (const Eigen::Index place : {line_drive, line_noise}) {
    if (best.x[place] > box.low[place] && best.x[place] < box.high[place]) free.push_back(place);
  }
  const Eigen::MatrixXd information = best.at.hessian(free, free);
  const Eigen::LLT<Eigen::MatrixXd> factor(information);
  if (factor.info() != Eigen::Success) return {};
  const Eigen::MatrixXd covariance =
      factor.solve(Eigen::MatrixXd::Identity(information.rows(), information.cols()));
  line.frequency_error = std::sqrt(covariance(0, 0)) / (2 * std::numbers::pi);
  line.decay_rate_error = std::sqrt(covariance(1, 1)) * line.decay_rate;
  return line;
}

}  // namespace carillon::eval::damping
