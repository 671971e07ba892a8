#include "synth/motion/detail/flight_delay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.hpp"

namespace carillon::synth::motion {

namespace {

constexpr int half = 32;             ///< samples to each side
constexpr int phases = 1024;         ///< between two samples; straight lines between: -118 dB
constexpr double kaiser_shape = 10;  ///< of Kaiser's window

/// The kernel at every phase: row p holds the weights of samples -half + 1 to half for a place
/// p / phases after sample 0.
const Eigen::Matrix<double, Eigen::Dynamic, 2 * half, Eigen::RowMajor>& kernel() {
  static const auto table = [] {
    Eigen::Matrix<double, Eigen::Dynamic, 2 * half, Eigen::RowMajor> rows(phases + 1, 2 * half);
    const double whole = boost::math::cyl_bessel_i(0, kaiser_shape);
    for (int phase = 0; phase <= phases; ++phase) {
      for (int tap = 0; tap < 2 * half; ++tap) {
        const double x = tap - half + 1 - static_cast<double>(phase) / phases;
        const double inside = 1 - x * x / (half * half);
        const double window =
            inside > 0 ? boost::math::cyl_bessel_i(0, kaiser_shape * std::sqrt(inside)) / whole : 0;
        const double angle = std::numbers::pi * x;
        rows(phase, tap) = window * (x == 0 ? 1 : std::sin(angle) / angle);
      }
      rows.row(phase) /= rows.row(phase).sum();
    }
    return rows;
  }();
  return table;
}

void check(const FlightTimes& flight) {
  if (flight.at.empty() || !(flight.step > 0)) {
    throw core::InputError("flight times: none, or no step between them");
  }
  for (std::size_t k = 0; k < flight.at.size(); ++k) {
    if (!(flight.at[k] >= 0) || !std::isfinite(flight.at[k])) {
      throw core::InputError(fmt::format("flight times: {} s at {:.4g} s", flight.at[k],
                                         static_cast<double>(k) * flight.step));
    }
    if (k > 0 && !(flight.step + flight.at[k] > flight.at[k - 1])) {
      throw core::InputError(
          fmt::format("flight times: at {:.4g} s a body comes nearer faster than "
                      "sound",
                      static_cast<double>(k) * flight.step));
    }
  }
}

}  // namespace

void add_arriving(const Eigen::Ref<const Eigen::VectorXd>& emitted, const FlightTimes& flight,
                  double sample_rate, Eigen::Ref<Eigen::VectorXd> heard) {
  check(flight);
  const auto& weights = kernel();
  const Eigen::Index last = emitted.size();
  std::size_t k = 0;
  for (Eigen::Index n = 0; n < heard.size(); ++n) {
    const double t = static_cast<double>(n) / sample_rate;
    const auto arrival = [&](std::size_t step) {
      return static_cast<double>(step) * flight.step + flight.at[step];
    };
    if (t < arrival(0)) {
      // Before the first state: as if the body had stood there; only the kernel's foot reaches
      // here.
      if (t < arrival(0) - half / sample_rate) continue;
    }
    while (k + 1 < flight.at.size() && arrival(k + 1) <= t) ++k;
    double left = t - flight.at[k];
    if (k + 1 < flight.at.size() && t >= arrival(0)) {
      const double fraction = (t - arrival(k)) / (arrival(k + 1) - arrival(k));
      left = (static_cast<double>(k) + fraction) * flight.step;
    }
    const double place = left * sample_rate;
    const double whole = std::floor(place);
    const double phase = (place - whole) * phases;
    const auto row = std::min(static_cast<int>(phase), phases - 1);
    const double between = phase - row;
    const Eigen::Index first = static_cast<Eigen::Index>(whole) - half + 1;
    const Eigen::Index from = std::max<Eigen::Index>(0, -first);
    const Eigen::Index to = std::min<Eigen::Index>(2 * half, last - first);
    if (to <= from) continue;
    const auto samples = emitted.segment(first + from, to - from);
    const double low = weights.row(row).segment(from, to - from).dot(samples);
    const double high = weights.row(row + 1).segment(from, to - from).dot(samples);
    heard[n] += low + between * (high - low);
  }
}

}  // namespace carillon::synth::motion
