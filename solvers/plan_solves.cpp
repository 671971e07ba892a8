#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "solvers/solve_materials.hpp"

namespace carillon::solvers {
namespace {

constexpr double lowest_ratio = 0, highest_ratio = 0.46;
constexpr double three_snapshots[] = {0.10, 0.30, 0.44};
/// Ratios this close to each other need two snapshots only.
constexpr double narrow = 0.12;
/// Doing without one basis for all must bring the cost down to this part.
constexpr double worth_splitting = 2.0 / 3;

bool close(double a, double b) {
  return std::abs(a - b) <= 1e-12 * std::abs(b);
}

bool can_share(const ModeRequest& request) {
  const double ratio = request.regions[0].poisson_ratio;
  return ratio >= lowest_ratio && ratio <= highest_ratio &&
         std::all_of(request.regions.begin(), request.regions.end(),
                     [ratio](const Elastic& e) { return e.poisson_ratio == ratio; });
}

bool same_contrasts(const std::vector<Elastic>& a, const std::vector<Elastic>& b) {
  for (std::size_t r = 1; r < a.size(); ++r) {
    if (!close(a[r].youngs_modulus * b[0].youngs_modulus,
               b[r].youngs_modulus * a[0].youngs_modulus) ||
        !close(a[r].density * b[0].density, b[r].density * a[0].density)) {
      return false;
    }
  }
  return true;
}

/// Band's top over the speed of sound [1/m].
double top_of(const ModeRequest& request) {
  const auto& first = request.regions[0];
  return request.band.max_frequency * std::sqrt(first.density / first.youngs_modulus);
}

std::vector<double> snapshots_for(std::span<const ModeRequest> requests,
                                  const std::vector<std::size_t>& members) {
  double low = 0.5, high = -1;
  for (const auto i : members) {
    low = std::min(low, requests[i].regions[0].poisson_ratio);
    high = std::max(high, requests[i].regions[0].poisson_ratio);
  }
  if (high - low > narrow) return {std::begin(three_snapshots), std::end(three_snapshots)};
  // Chebyshev's points of the range.
  const double middle = (low + high) / 2, half = (high - low) / (2 * std::sqrt(2.0));
  return {middle - half, middle + half};
}

/// A run of requests by ascending top, served in one of two ways.
struct Run {
  SolveGroup group;
  double cost = 0;
};

Run alone(std::span<const ModeRequest> requests, std::vector<std::size_t> members, double fixed) {
  double cost = 0;
  for (const auto i : members) cost += fixed + top_of(requests[i]);
  return {{std::move(members), {}}, cost};
}

Run joined(std::span<const ModeRequest> requests, std::vector<std::size_t> members, double fixed) {
  auto snapshots = snapshots_for(requests, members);
  const double cost =
      static_cast<double>(snapshots.size()) * (fixed + top_of(requests[members.back()]));
  return {{std::move(members), std::move(snapshots)}, cost};
}

/// Serves requests of ascending tops.
void split(std::span<const ModeRequest> requests, const std::vector<std::size_t>& members,
           std::vector<SolveGroup>& out) {
  const double fixed = top_of(requests[members.front()]);
  auto whole = joined(requests, members, fixed);
  if (members.size() <= whole.group.snapshots.size()) {
    out.push_back(alone(requests, members, fixed).group);
    return;
  }
  const auto best_run = [&](std::size_t from, std::size_t to) {
    const std::vector<std::size_t> part(members.begin() + static_cast<std::ptrdiff_t>(from),
                                        members.begin() + static_cast<std::ptrdiff_t>(to));
    auto a = alone(requests, part, fixed), b = joined(requests, part, fixed);
    return b.cost < a.cost ? b : a;
  };
  // The cheapest cut into runs.
  const auto count = members.size();
  std::vector<double> cost(count + 1, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> from(count + 1, 0);
  cost[0] = 0;
  for (std::size_t to = 1; to <= count; ++to) {
    for (std::size_t begin = 0; begin < to; ++begin) {
      const double total = cost[begin] + best_run(begin, to).cost;
      if (total < cost[to]) {
        cost[to] = total;
        from[to] = begin;
      }
    }
  }
  if (cost[count] > worth_splitting * whole.cost) {
    out.push_back(std::move(whole.group));
    return;
  }
  for (std::size_t to = count; to > 0; to = from[to]) {
    out.push_back(best_run(from[to], to).group);
  }
}

}  // namespace

std::vector<SolveGroup> plan_solves(std::span<const ModeRequest> requests) {
  std::vector<std::vector<std::size_t>> classes;
  std::vector<SolveGroup> groups;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    if (!can_share(requests[i])) {
      groups.push_back({{i}, {}});
      continue;
    }
    const auto of_equals =
        std::find_if(classes.begin(), classes.end(), [&](const std::vector<std::size_t>& members) {
          return same_contrasts(requests[i].regions, requests[members[0]].regions);
        });
    if (of_equals == classes.end()) {
      classes.push_back({i});
    } else {
      of_equals->push_back(i);
    }
  }
  for (auto& members : classes) {
    std::stable_sort(members.begin(), members.end(), [&](std::size_t a, std::size_t b) {
      return top_of(requests[a]) < top_of(requests[b]);
    });
    split(requests, members, groups);
  }
  return groups;
}

}  // namespace carillon::solvers
