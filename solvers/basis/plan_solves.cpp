#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "solvers/basis/solve_materials.hpp"

namespace carillon::solvers::basis {
namespace {

constexpr double lowest_ratio = 0, highest_ratio = 0.46;
constexpr double three_snapshots[] = {0.10, 0.30, 0.44};
/// Ratios this close to each other need two snapshots only.
constexpr double narrow = 0.12;
constexpr std::size_t min_snapshots = 2;
/// Doing without one basis for all must bring the cost down to this part.
constexpr double worth_splitting = 2.0 / 3;

bool close(double a, double b) {
  return std::abs(a - b) <= 1e-12 * std::abs(b);
}

bool can_fraction(const ModeRequest& request) {
  const double ratio = request.regions[0].poisson_ratio;
  return ratio >= lowest_ratio && ratio <= highest_ratio &&
         std::all_of(request.regions.begin(), request.regions.end(),
                     [ratio](const elements::Elastic& e) {
                       return e.poisson_ratio == ratio && !e.anisotropy;
                     });
}

bool same_contrasts(const std::vector<elements::Elastic>& a,
                    const std::vector<elements::Elastic>& b) {
  for (std::size_t r = 1; r < a.size(); ++r) {
    if (!close(a[r].youngs_modulus * b[0].youngs_modulus,
               b[r].youngs_modulus * a[0].youngs_modulus) ||
        !close(a[r].density * b[0].density, b[r].density * a[0].density)) {
      return false;
    }
  }
  return true;
}

/// Modes that a solve of each request is expected to find; not looked at where too few are there to
/// share a basis.
std::vector<double> modes_of_solves(const mesh::TetMesh& mesh,
                                    std::span<const ModeRequest> requests) {
  std::vector<double> modes(requests.size(), 0.0);
  if (requests.size() <= min_snapshots) return modes;
  const double volume = mesh::measure_quality(mesh).volume, thickness = mesh::mean_thickness(mesh);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto& [regions, band] = requests[i];
    const auto below = [&, &elastic = regions[0]](double frequency) {
      return expected_modes(volume, thickness, elastic, frequency);
    };
    modes[i] = std::min(below(band.max_frequency), below(band.bottom()) + band.max_modes);
  }
  return modes;
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

/// Processor time of finding so many modes, that of one of few being 1: ordering, counting and
/// factoring, iterations, and orthogonalising. Fitted to a tile of 13,872 unknowns with 60 and with
/// 390 modes (docs/performance.md), as are the other two.
double cost_of_solve(double modes) {
  return 20 + modes + modes * modes / 325;
}
/// Joining snapshots that hold the modes of so many.
double cost_of_basis(double modes) {
  return 0.57 * modes + modes * modes / 280;
}
/// One request's modes from a basis.
double cost_of_ritz(double modes) {
  return 0.2 * modes + modes * modes / 2500;
}

/// A run of requests by ascending number of modes, served in one of two ways.
struct Run {
  SolveGroup group;
  double cost = 0;
};

Run alone(std::span<const double> modes, std::vector<std::size_t> members) {
  double cost = 0;
  for (const auto i : members) cost += cost_of_solve(modes[i]);
  return {{std::move(members), {}}, cost};
}

Run joined(std::span<const ModeRequest> requests, std::span<const double> modes,
           std::vector<std::size_t> members) {
  auto snapshots = snapshots_for(requests, members);
  const double maximum = modes[members.back()];
  const double cost = static_cast<double>(snapshots.size()) * cost_of_solve(maximum) +
                      cost_of_basis(maximum) +
                      static_cast<double>(members.size()) * cost_of_ritz(maximum);
  return {{std::move(members), std::move(snapshots)}, cost};
}

/// Serves requests of ascending numbers of modes from one basis, or by the cheapest cut into
/// runs where that is much cheaper.
void split(std::span<const ModeRequest> requests, std::span<const double> modes,
           const std::vector<std::size_t>& members, std::vector<SolveGroup>& out) {
  const auto best_run = [&](std::size_t from, std::size_t to) {
    const std::vector<std::size_t> part(members.begin() + static_cast<std::ptrdiff_t>(from),
                                        members.begin() + static_cast<std::ptrdiff_t>(to));
    auto a = alone(modes, part), b = joined(requests, modes, part);
    return b.group.snapshots.size() < part.size() && b.cost < a.cost ? b : a;
  };
  const auto count = members.size();
  auto whole = joined(requests, modes, members);
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
  if (whole.group.snapshots.size() < count && cost[count] > worth_splitting * whole.cost) {
    out.push_back(std::move(whole.group));
    return;
  }
  for (std::size_t to = count; to > 0; to = from[to]) {
    out.push_back(best_run(from[to], to).group);
  }
}

}  // namespace

double expected_modes(double volume, double thickness, const elements::Elastic& elastic,
                      double frequency) {
  const double area = volume / thickness, nu = elastic.poisson_ratio;
  const double plane = elastic.youngs_modulus / elastic.density;
  const double plate = std::sqrt(plane / (1 - nu * nu)), shear = std::sqrt(plane / (2 + 2 * nu)),
               dilatation = std::sqrt(plane * (1 - nu) / ((1 + nu) * (1 - 2 * nu)));
  const double bending = std::sqrt(3.0) * area * frequency / (plate * thickness);
  const double in_plane =
      std::numbers::pi * area * frequency * frequency * (std::pow(plate, -2) + std::pow(shear, -2));
  const double solid = 4 * std::numbers::pi / 3 * volume * std::pow(frequency, 3) *
                       (2 * std::pow(shear, -3) + std::pow(dilatation, -3));
  return bending + in_plane + solid;
}

std::vector<SolveGroup> plan_solves(const mesh::TetMesh& mesh,
                                    std::span<const ModeRequest> requests) {
  const auto modes = modes_of_solves(mesh, requests);
  std::vector<std::vector<std::size_t>> classes;
  std::vector<SolveGroup> groups;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    if (!can_fraction(requests[i])) {
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
    std::stable_sort(members.begin(), members.end(),
                     [&](std::size_t a, std::size_t b) { return modes[a] < modes[b]; });
    split(requests, modes, members, groups);
  }
  return groups;
}

}  // namespace carillon::solvers::basis
