#include "solvers/modes/modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "core/error.hpp"

namespace carillon::solvers::modes {
namespace {

constexpr std::array<std::string_view, 3> linear_solvers = {"automatic", "direct", "iterative"};
constexpr std::array<std::string_view, 5> eigen_solvers = {"block_lanczos", "krylov_schur",
                                                           "lobpcg", "dense", "slepc"};

template <class Enum, std::size_t N>
Enum parse(const std::array<std::string_view, N>& names, std::string_view name, const char* what) {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) {
    throw core::InputError(fmt::format("\"{}\" is no {}", name, what),
                           fmt::format("known are {}", fmt::join(names, ", ")));
  }
  return static_cast<Enum>(at - names.begin());
}

}  // namespace

double Modes::frequency(std::size_t mode) const {
  return std::sqrt(eigenvalues.at(mode)) / (2 * std::numbers::pi);
}

std::size_t whole_clusters(std::span<const double> eigenvalues, std::size_t maximum) {
  constexpr double repeated = 1e-4;
  if (eigenvalues.size() <= maximum) return eigenvalues.size();
  std::size_t count = maximum;
  while (count > 0 && eigenvalues[count] - eigenvalues[count - 1] <= repeated * eigenvalues[count])
    --count;
  return count > 0 ? count : maximum;
}

Modes rescale(const Modes& modes, double length, double modulus, double density) {
  Modes out = modes;
  const double eigenvalue = modulus / (density * length * length);
  const double frequency = std::sqrt(eigenvalue);
  const double mass = density * length * length * length;
  for (auto& lambda : out.eigenvalues) lambda *= eigenvalue;
  for (auto& node : out.surface.nodes) node *= length;
  out.shapes *= static_cast<float>(1 / std::sqrt(mass));
  out.mass *= mass;
  out.certificate.min_frequency *= frequency;
  out.certificate.max_frequency *= frequency;
  out.certificate.complete_to_hz *= frequency;
  return out;
}

Modes restrict_to(const Modes& modes, const Band& band) {
  std::vector<Eigen::Index> inside;
  std::int64_t below = 0;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const double frequency = modes.frequency(k);
    below += frequency < band.min_frequency;
    if (frequency >= band.min_frequency && frequency <= band.max_frequency) {
      inside.push_back(static_cast<Eigen::Index>(k));
    }
  }
  const auto in_band = static_cast<std::int64_t>(inside.size());
  std::vector<double> ascending;
  for (const auto k : inside) {
    ascending.push_back(modes.eigenvalues[static_cast<std::size_t>(k)]);
  }
  inside.resize(whole_clusters(ascending, static_cast<std::size_t>(band.max_modes)));

  Modes out;
  out.surface = modes.surface;
  out.mass = modes.mass;
  out.certificate = modes.certificate;
  for (const auto k : inside) {
    const auto mode = static_cast<std::size_t>(k);
    out.eigenvalues.push_back(modes.eigenvalues[mode]);
    out.residuals.push_back(modes.residuals[mode]);
    if (!modes.pitch_errors.empty()) out.pitch_errors.push_back(modes.pitch_errors[mode]);
    if (!modes.given_decay_rates.empty())
      out.given_decay_rates.push_back(modes.given_decay_rates[mode]);
  }
  out.shapes = modes.shapes.select(inside);
  out.kinetic_fraction = modes.kinetic_fraction(inside, Eigen::all);
  out.strain_fraction = modes.strain_fraction(inside, Eigen::all);

  auto& certificate = out.certificate;
  certificate.min_frequency = band.min_frequency;
  certificate.max_frequency = band.max_frequency;
  certificate.modes_found = static_cast<std::int64_t>(inside.size());
  certificate.max_residual =
      out.residuals.empty() ? 0 : *std::max_element(out.residuals.begin(), out.residuals.end());
  // Up to there every mode is known, if the band does not begin below the first one.
  // The ends of a rescaled band carry rounding.
  constexpr double rounding = 1e-9;
  const bool known = band.max_frequency <= modes.certificate.complete_to_hz * (1 + rounding) &&
                     band.min_frequency >= modes.certificate.min_frequency * (1 - rounding);
  certificate.modes_in_band = known ? in_band : modes.certificate.modes_in_band - below;
  certificate.complete = known && certificate.modes_found == in_band;
  certificate.complete_to_hz =
      known ? band.max_frequency : std::min(band.max_frequency, modes.certificate.complete_to_hz);
  if (certificate.modes_found < in_band) {
    const auto last = static_cast<std::size_t>(inside.back());
    const double limit = (modes.frequency(last) + modes.frequency(last + 1)) / 2;
    certificate.complete_to_hz = std::min(certificate.complete_to_hz, limit);
  }
  return out;
}

std::string_view name_of(LinearSolver solver) {
  return linear_solvers[static_cast<std::size_t>(solver)];
}

std::string_view name_of(EigenSolver solver) {
  return eigen_solvers[static_cast<std::size_t>(solver)];
}

LinearSolver parse_linear_solver(std::string_view name) {
  return parse<LinearSolver>(linear_solvers, name, "linear solver");
}

EigenSolver parse_eigen_solver(std::string_view name) {
  return parse<EigenSolver>(eigen_solvers, name, "eigensolver");
}

mesh::SurfaceMesh flatten(const ModeSurface& surface) {
  mesh::SurfaceMesh out;
  out.vertices = surface.nodes;
  const int p = surface.order;
  const auto& lattice = elements::triangle_lattice(p);
  std::map<std::array<int, 3>, std::size_t> local;
  for (std::size_t n = 0; n < lattice.size(); ++n) local[lattice[n]] = n;
  std::vector<std::array<std::size_t, 3>> pieces;
  for (int j = 0; j < p; ++j) {
    for (int k = 0; j + k < p; ++k) {
      const int i = p - j - k;
      pieces.push_back(
          {local.at({i, j, k}), local.at({i - 1, j + 1, k}), local.at({i - 1, j, k + 1})});
      if (i < 2) continue;
      pieces.push_back({local.at({i - 1, j + 1, k}), local.at({i - 2, j + 1, k + 1}),
                        local.at({i - 1, j, k + 1})});
    }
  }
  for (std::size_t first = 0; first < surface.faces.size(); first += lattice.size()) {
    for (const auto& piece : pieces) {
      out.triangles.push_back({surface.faces[first + piece[0]], surface.faces[first + piece[1]],
                               surface.faces[first + piece[2]]});
    }
  }
  return out;
}

}  // namespace carillon::solvers::modes
