#include "eval/statistics/parzen_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace carillon::eval::statistics {

namespace {

constexpr double good_fraction = 0.15;
constexpr std::size_t draws_per_point = 24;
/// Draws anywhere until one is taken to have tried all.
constexpr std::size_t draws_until_none = 10000;

double normal_cdf(double x) {
  return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

/// Normal density between 0 and 1.
struct Kernel {
  double mean = 0.5, deviation = 1;

  double mass() const { return normal_cdf((1 - mean) / deviation) - normal_cdf(-mean / deviation); }
  double density(double x) const {
    const double z = (x - mean) / deviation;
    return std::exp(-z * z / 2) / (std::sqrt(2 * std::numbers::pi) * deviation * mass());
  }
};

/// What a set of points says of one axis.
class AxisDensity {
 public:
  AxisDensity(ParzenAxis axis, std::vector<double> values) : axis_(axis) {
    if (axis.choices > 0) {
      const auto count = static_cast<double>(values.size() + axis.choices);
      fractions_.assign(axis.choices, 1 / count);
      for (const double value : values) fractions_[static_cast<std::size_t>(value)] += 1 / count;
      return;
    }
    std::sort(values.begin(), values.end());
    const double narrowest = 1 / std::min(100.0, 1 + static_cast<double>(values.size()));
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double left = values[i] - (i > 0 ? values[i - 1] : 0);
      const double right = (i + 1 < values.size() ? values[i + 1] : 1) - values[i];
      kernels_.push_back({values[i], std::clamp(std::max(left, right), narrowest, 1.0)});
    }
    kernels_.push_back({});
  }

  double draw(core::RandomStream& random) const {
    if (axis_.choices > 0) {
      double left = random.uniform();
      for (std::size_t i = 0; i + 1 < fractions_.size(); ++i) {
        left -= fractions_[i];
        if (left < 0) return static_cast<double>(i);
      }
      return static_cast<double>(fractions_.size() - 1);
    }
    const Kernel& kernel = kernels_[random.index(kernels_.size())];
    for (;;) {  // at least a third of each kernel lies within
      const double x = kernel.mean + kernel.deviation * random.normal();
      if (x >= 0 && x <= 1) return x;
    }
  }

  double density(double x) const {
    if (axis_.choices > 0) return fractions_[static_cast<std::size_t>(x)];
    double sum = 0;
    for (const Kernel& kernel : kernels_) sum += kernel.density(x);
    return sum / static_cast<double>(kernels_.size());
  }

 private:
  ParzenAxis axis_;
  std::vector<double> fractions_;  ///< of each choice
  std::vector<Kernel> kernels_;
};

std::vector<AxisDensity> densities(std::span<const ParzenAxis> axes,
                                   std::span<const ParzenPoint> points) {
  std::vector<AxisDensity> all;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    std::vector<double> values;
    for (const ParzenPoint& point : points) values.push_back(point[a]);
    all.emplace_back(axes[a], std::move(values));
  }
  return all;
}

ParzenPoint draw(std::span<const AxisDensity> densities, core::RandomStream& random) {
  ParzenPoint point;
  for (const AxisDensity& axis : densities) point.push_back(axis.draw(random));
  return point;
}

ParzenPoint anywhere(std::span<const ParzenAxis> axes, core::RandomStream& random) {
  ParzenPoint point;
  for (const ParzenAxis& axis : axes) {
    point.push_back(axis.choices > 0 ? static_cast<double>(random.index(axis.choices))
                                     : random.uniform());
  }
  return point;
}

}  // namespace

std::optional<ParzenPoint> next_parzen_point(std::span<const ParzenAxis> axes,
                                             std::span<const ParzenPoint> best_first,
                                             core::RandomStream& random) {
  const auto is_new = [&](const ParzenPoint& point) {
    return std::find(best_first.begin(), best_first.end(), point) == best_first.end();
  };
  if (best_first.size() >= parzen_drawn_first) {
    const auto good =
        static_cast<std::size_t>(std::ceil(good_fraction * static_cast<double>(best_first.size())));
    const std::vector<AxisDensity> of_good = densities(axes, best_first.first(good));
    const std::vector<AxisDensity> of_others = densities(axes, best_first.subspan(good));
    std::optional<ParzenPoint> best;
    double highest = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < draws_per_point; ++i) {
      ParzenPoint point = draw(of_good, random);
      double log_ratio = 0;
      for (std::size_t a = 0; a < axes.size(); ++a) {
        log_ratio += std::log(of_good[a].density(point[a]) / of_others[a].density(point[a]));
      }
      if (log_ratio <= highest || !is_new(point)) continue;
      highest = log_ratio;
      best = std::move(point);
    }
    if (best) return best;
  }
  for (std::size_t i = 0; i < draws_until_none; ++i) {
    ParzenPoint point = anywhere(axes, random);
    if (is_new(point)) return point;
  }
  return {};
}

}  // namespace carillon::eval::statistics
