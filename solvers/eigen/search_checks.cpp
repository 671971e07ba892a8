#include "solvers/eigen/search_checks.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "core/error.hpp"

namespace carillon::solvers::eigen {
namespace {

constexpr double largest_residual = 1e-6;
/// In the energy norm, whose square bounds the relative error of an eigenvalue: 0.1 cents. The
/// rounding of K alone comes to 2e-3 on a plate of 1 to 1000 at order 4, whose frequencies are
/// right to 0.01 cents.
constexpr double largest_energy_residual = 1e-2;
/// Eigenvalues closer than this (relative) count as one: no shift fits between them safely.
constexpr double smallest_gap = 1e-6;
/// An interval of so few modes is sliced whole rather than halved by one more factorisation.
constexpr std::int64_t few_modes = 8;

/// A value, the modes that were found below it and those that are there.
struct Cut {
  double value = 0;
  std::int64_t found = 0, counted = 0;
};

/// Cuts in every gap from the first flexible mode's upward, below `top`.
std::vector<Cut> gaps_of(const SearchResult& found, double top) {
  std::vector<Cut> gaps;
  for (std::size_t k = 1; k < found.flexible.size(); ++k) {
    const auto value = gap_below(found, k);
    if (value && *value < top) gaps.push_back({*value, static_cast<std::int64_t>(k), 0});
  }
  return gaps;
}

std::int64_t found_below(const SearchResult& found, double value) {
  return std::count_if(found.flexible.begin(), found.flexible.end(),
                       [&](std::size_t k) { return found.pairs.values[k] < value; });
}

/// Halves the stretch between two cuts until what is lacking is fenced in.
void bisect(std::span<const Cut> gaps, const Cut& low, const Cut& high, std::int64_t rigid,
            const Count& count, std::vector<Lack>& lacks) {
  if (high.counted - low.counted == high.found - low.found) return;
  if (gaps.empty() || high.found - low.found <= few_modes) {
    lacks.push_back({low.value, high.value});
    return;
  }
  Cut middle = gaps[gaps.size() / 2];
  middle.counted = count(middle.value) - rigid;
  bisect(gaps.first(gaps.size() / 2), low, middle, rigid, count, lacks);
  bisect(gaps.subspan(gaps.size() / 2 + 1), middle, high, rigid, count, lacks);
}

}  // namespace

double flexible_value(const SearchResult& found, std::size_t k) {
  return found.pairs.values[found.flexible.at(k)];
}

std::optional<double> gap_below(const SearchResult& found, std::size_t k) {
  const double low = k == 0 ? 0 : flexible_value(found, k - 1), high = flexible_value(found, k);
  if (high - low < smallest_gap * high) return std::nullopt;
  return (low + high) / 2;
}

double worst_residual(const SearchResult& found, std::int64_t wanted) {
  double worst = 0;
  const auto count = std::min(static_cast<std::size_t>(wanted), found.flexible.size());
  for (std::size_t k = 0; k < count; ++k) {
    worst = std::max(worst, found.pairs.residuals[found.flexible[k]]);
  }
  return worst;
}

void refuse_bad_residuals(const SearchResult& found, std::int64_t wanted,
                          const assembly::Scales& scales) {
  const auto& pairs = found.pairs;
  const auto count = std::min(static_cast<std::size_t>(wanted), found.flexible.size());
  for (std::size_t k = 0; k < count; ++k) {
    const auto i = found.flexible[k];
    if (pairs.residuals[i] <= largest_residual ||
        pairs.energy_residuals[i] <= largest_energy_residual) {
      continue;
    }
    throw core::SolverError(
        fmt::format("the mode at {:.6g} Hz has a residual of {:.1e} (in the energy norm {:.1e}) "
                    "and should be below {:.0e} ({:.0e})",
                    scales.to_frequency(pairs.values[i]), pairs.residuals[i],
                    pairs.energy_residuals[i], largest_residual, largest_energy_residual),
        "the mesh may have elements that are nearly flat");
  }
}

void refuse_mechanism(const EigenPairs& pairs, std::int64_t rigid, double estimate) {
  const auto zeros = std::count_if(pairs.values.begin(), pairs.values.end(),
                                   [estimate](double v) { return v < 1e-9 * estimate; });
  if (zeros <= rigid) return;
  throw core::SolverError(
      fmt::format("the object has {} motions without strain beside the {} rigid ones: parts of it "
                  "hang together by a single point or edge",
                  zeros - rigid, rigid),
      "join the parts by a face, or separate them");
}

std::vector<Lack> find_lacks(const SearchResult& found, std::int64_t rigid, double top,
                             const Count& count) {
  const Cut high{top, found_below(found, top), count(top) - rigid};
  if (high.counted == high.found) return {};
  // A fence below every flexible mode; those that are missing may lie below all that were found.
  // Far down a count drowns in rounding, and there is nothing to be found either.
  const double first = found.flexible.empty() ? top : std::min(top, flexible_value(found, 0));
  Cut low;
  for (double value = first / 2; value > 1e-4 * first; value /= 4) {
    low = {value, 0, count(value) - rigid};
    if (low.counted == 0) break;
  }
  std::vector<Lack> lacks;
  if (low.counted != 0) return lacks;
  const auto gaps = gaps_of(found, top);
  bisect(gaps, low, high, rigid, count, lacks);
  return lacks;
}

EigenPairs with_slices(const SearchResult& found, std::span<const Lack> lacks,
                       std::span<const EigenPairs> slices) {
  /// A column of one of the sets.
  struct Source {
    double value;
    const EigenPairs* set;
    Eigen::Index column;
  };
  std::vector<Source> sources;
  for (std::size_t k = 0; k < found.pairs.values.size(); ++k) {
    const double value = found.pairs.values[k];
    const bool replaced = std::any_of(lacks.begin(), lacks.end(), [value](const Lack& lack) {
      return value >= lack.low && value < lack.high;
    });
    if (!replaced) sources.push_back({value, &found.pairs, static_cast<Eigen::Index>(k)});
  }
  for (const auto& slice : slices) {
    for (std::size_t k = 0; k < slice.values.size(); ++k) {
      sources.push_back({slice.values[k], &slice, static_cast<Eigen::Index>(k)});
    }
  }
  std::stable_sort(sources.begin(), sources.end(),
                   [](const Source& a, const Source& b) { return a.value < b.value; });
  EigenPairs out;
  out.vectors.resize(found.pairs.vectors.rows(), static_cast<Eigen::Index>(sources.size()));
  for (std::size_t k = 0; k < sources.size(); ++k) {
    out.values.push_back(sources[k].value);
    out.vectors.col(static_cast<Eigen::Index>(k)) = sources[k].set->vectors.col(sources[k].column);
  }
  return out;
}

double verified_prefix(const SearchResult& found, std::int64_t rigid, const Count& count) {
  // A mode that is missing anywhere below a gap shows there, so the answer is monotonic.
  const auto gaps = gaps_of(found, std::numeric_limits<double>::infinity());
  double good = 0;
  std::size_t low = 0, high = gaps.size();
  while (low < high) {
    const auto middle = (low + high) / 2;
    if (count(gaps[middle].value) - rigid == gaps[middle].found) {
      good = gaps[middle].value;
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return good;
}

}  // namespace carillon::solvers::eigen
