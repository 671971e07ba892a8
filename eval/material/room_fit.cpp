#include "eval/material/room_fit.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "eval/material/detail/law_search.hpp"
#include "eval/material/detail/minimise.hpp"

namespace carillon::eval::material {

namespace {

constexpr double unusable = 1e6;  // of the objective, where a law is not positive
constexpr double search_tolerance = 1e-8;
constexpr int max_search_evaluations = 2000;
// Figures of the density (room_fit.hpp): measured in rooms of 0.2 to 1 s
// (docs/material-estimation.md).
constexpr double seldom = 0.05;         // a mode far faster than the room is heard as it is
constexpr double always = 0.95;         // and a slow one is
constexpr double turning_point = 0.7;   // of law over room: as often as not
constexpr double blur = 0.25;           // of decays as fast as the room's
constexpr double farthest_blur = 3;     // law over room, beyond which it does not grow
constexpr double masked_slope = 0.6;    // with which fast modes are heard faster than the room
constexpr double masked_most = 0.5;     // [logarithm]
constexpr double masked_scatter = 0.6;  // of what is heard of them [logarithm]
constexpr double outlier_share = 0.02;
constexpr double usual_scatter = 0.03;
constexpr double scatter_spread = 0.7;  // of its logarithm
/// Share of the room's rate below which a point is taken for its own at the start.
constexpr double slow = 0.5;

constexpr double unknown_error = 0.15;  // relative, of a point whose error nobody states
constexpr double well_known = 0.15;     // relative scatter up to which a point counts in full

/// Both parts of a point's density.
struct PointDensity {
  double own = 0;
  double all = 0;
  double scale = 0;  ///< of its own part
};

PointDensity density_of(double heard, double law, double room, double error, double scatter) {
  const double ratio = std::log(heard / law);
  const double u = law / room;
  const double spread = blur * std::pow(std::min(u, farthest_blur), 2);
  const double scale = std::sqrt(scatter * scatter + error * error + spread * spread);
  const double q = 1 + 0.25 * ratio * ratio / (scale * scale);
  const double weight = seldom + (always - seldom) / (1 + std::pow(u / turning_point, 4));
  const double tail = std::exp(-std::abs(ratio));
  PointDensity density;
  density.scale = scale;
  density.own = weight * 0.375 / (scale * q * q * std::sqrt(q));
  density.all = density.own + outlier_share * tail / ((1 + tail) * (1 + tail));
  if (std::isfinite(room)) {
    const double shift = std::clamp(masked_slope * std::log(u), 0.0, masked_most);
    const double z = (std::log(heard / room) - shift) / masked_scatter;
    density.all +=
        (1 - weight) * std::exp(-0.5 * z * z) / (masked_scatter * std::sqrt(2 * std::numbers::pi));
  }
  return density;
}

/// Minus twice the logarithm of the likelihood, with the prior of the scatter.
struct RoomObjective {
  const damping::DampingData& data;
  std::span<const double> rooms;
  const LawSearch& search;

  double error(std::size_t i) const {
    if (data.errors.empty() || !std::isfinite(data.errors[i])) return unknown_error;
    return data.errors[i] / data.coefficients[i];
  }
  /// @param y  coordinates of the law, then the logarithm of the scatter
  double operator()(std::span<const double> y) const {
    const std::vector<double> law = search.coefficients(y, data.eigenvalues);
    if (law.empty()) return unusable;
    const double prior = (y.back() - std::log(usual_scatter)) / scatter_spread;
    double sum = prior * prior;
    for (std::size_t i = 0; i < law.size(); ++i) {
      const double density =
          density_of(data.coefficients[i], law[i], rooms[i], error(i), std::exp(y.back())).all;
      sum -= 2 * std::log(std::max(density, 1e-300));
    }
    return std::isfinite(sum) ? std::min(sum, unusable) : unusable;
  }
  /// How many points are the law's, each by its probability, and how many tell of it, each by how
  /// well it is known too.
  std::pair<double, double> own(std::span<const double> y) const {
    const std::vector<double> law = search.coefficients(y, data.eigenvalues);
    std::pair<double, double> sums;
    for (std::size_t i = 0; i < law.size(); ++i) {
      const PointDensity density =
          density_of(data.coefficients[i], law[i], rooms[i], error(i), std::exp(y.back()));
      const double probability = density.own / density.all;
      sums.first += probability;
      sums.second += probability * std::min(1.0, std::pow(well_known / density.scale, 2));
    }
    return sums;
  }
};

/// The points that are slower than the room.
damping::DampingData slow_points(const damping::DampingData& data, std::span<const double> rooms) {
  damping::DampingData out;
  for (std::size_t i = 0; i < data.size(); ++i) {
    if (data.coefficients[i] > slow * rooms[i]) continue;
    out.eigenvalues.push_back(data.eigenvalues[i]);
    out.coefficients.push_back(data.coefficients[i]);
  }
  return out;
}

std::optional<damping::DampingFit> plain_fit(const damping::DampingData& data,
                                             const damping::DampingLaw& law,
                                             damping::Estimator estimator) {
  try {
    return damping::fit_damping(data, law, {.estimator = estimator, .confidence = false});
  } catch (const core::InputError&) {
    return std::nullopt;  // too few points
  }
}

}  // namespace

RoomFit fit_in_room(const damping::DampingData& data, std::span<const double> rooms,
                    const damping::DampingLaw& law) {
  using damping::Estimator;
  const damping::DampingFit plain =
      damping::fit_damping(data, law, {.estimator = Estimator::least_squares, .confidence = false});
  const LawSearch search = law_search(data, law, plain.model.parameters);
  const RoomObjective objective{data, rooms, search};
  const damping::DampingData below = slow_points(data, rooms);
  Minimum best;
  best.value = 2 * unusable;
  for (const auto& start : {std::optional(plain), plain_fit(data, law, Estimator::lower_bound),
                            plain_fit(below, law, Estimator::least_squares),
                            plain_fit(below, law, Estimator::lower_bound)}) {
    if (!start) continue;
    std::vector<double> y = search.coordinates(start->model.parameters);
    y.push_back(std::log(usual_scatter));
    const std::vector<double> steps(y.size(), 0.3);
    Minimum minimum = minimise(objective, y, steps, search_tolerance, max_search_evaluations);
    minimum = minimise(objective, minimum.x, steps, search_tolerance, max_search_evaluations);
    if (minimum.value < best.value) best = minimum;
  }
  const auto [likely, telling] = objective.own(best.x);
  RoomFit found;
  found.own = telling;
  found.model = plain.model;
  found.model.parameters = search.parameters(best.x);
  found.sigma = std::exp(best.x.back());
  const std::size_t count = found.model.parameters.size();
  const double freedom = std::max(1.0, likely - static_cast<double>(count));
  const double t = boost::math::quantile(boost::math::students_t(freedom), 0.975);
  const double limit = best.value + (freedom + 1) * std::log1p(t * t / freedom);
  for (std::size_t k = 0; k < count; ++k) {
    const core::Range range = profile_range(objective, best.x, k, limit);
    found.confidence95.push_back({search.parameter(k, range.low), search.parameter(k, range.high)});
  }
  return found;
}

}  // namespace carillon::eval::material
