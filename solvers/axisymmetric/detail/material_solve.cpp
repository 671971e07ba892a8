#include "solvers/axisymmetric/detail/material_solve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/numbers.hpp"
#include "solvers/axisymmetric/detail/harmonic_surface.hpp"
#include "solvers/eigen/extract.hpp"

namespace carillon::solvers::axisymmetric {
namespace {

using std::numbers::pi;
/// Bodies with more modes than this in the band are not solved far beyond max_modes.
constexpr double many_modes = 300;
/// Far below the first mode an inertia count drowns in rounding.
constexpr double lowest_count = 0.05;

/// Modes below a frequency, roughly: bending waves of the wall (Courant's asymptotics on half of
/// the surface) and waves of the solid.
double expected_modes(const mesh::MeridianSize& size, const elements::Elastic& m,
                      double frequency) {
  const double omega = 2 * pi * frequency;
  const double bar = std::sqrt(m.youngs_modulus / m.density);
  const double bending = omega * std::sqrt(12.0) / (bar * size.wall);
  const double shear = omega / (bar / std::sqrt(2 * (1 + m.poisson_ratio)));
  return size.surface / 2 / (4 * pi) * (bending + shear * shear) +
         size.volume / (6 * pi * pi) * 2.2 * std::pow(shear, 3);
}

double cents_between(double eigenvalue, double other) {
  return 0.5 * std::abs(core::cents(eigenvalue / other));
}

}  // namespace

double MaterialSolve::Found::frequency() const {
  return std::sqrt(eigenvalue) / (2 * pi);
}

MaterialSolve::MaterialSolve(const mesh::MeridianSize& size, const elements::Elastic& material,
                             const modes::Band& band, const eigen::SolveOptions& options,
                             core::Trace& trace)
    : size_(size),
      material_(material),
      band_(band),
      options_(options),
      trace_(trace),
      estimate_(estimate_first_frequency(size, material)),
      top_(first_top()) {}

/// The band's top, or a lower frequency below which there should be twice the modes wanted.
double MaterialSolve::first_top() const {
  const double top = band_.max_frequency;
  const auto expected = [this](double f) {
    return axisymmetric::expected_modes(size_, material_, f);
  };
  const double below = expected(band_.bottom());
  const double enough = 2 * static_cast<double>(wanted()) + below;
  if (expected(top) <= std::max(many_modes + below, 2 * enough)) return top;
  return std::min(top, std::max(frequency_of(enough), 2 * estimate_));
}

double MaterialSolve::frequency_of(double modes) const {
  double low = band_.bottom(), high = band_.max_frequency;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (axisymmetric::expected_modes(size_, material_, middle) < modes ? low : high) = middle;
  }
  return high;
}

double MaterialSolve::expected_modes() const {
  const auto below = [this](double frequency) {
    return axisymmetric::expected_modes(size_, material_, frequency);
  };
  return std::min(below(band_.max_frequency) - below(band_.bottom()),
                  static_cast<double>(wanted()));
}

double MaterialSolve::expected_harmonic() const {
  // Of what largest_wave_number() allows for.
  constexpr double kept = 0.58;
  const double below = axisymmetric::expected_modes(size_, material_, band_.bottom());
  const double top = frequency_of(below + expected_modes());
  return kept * axisymmetric::largest_wave_number(size_, material_, top) * size_.largest_radius;
}

double MaterialSolve::largest_wave_number() const {
  return axisymmetric::largest_wave_number(size_, material_, std::max(top_, estimate_));
}

/// Whether max_modes lie above the bottom of the band; those below it are few beside the modes
/// that are counted, or the frequency grows further.
bool MaterialSolve::enough() const {
  std::int64_t below = 0, counted = 0;
  const double bottom = band_.bottom();
  if (bottom > lowest_count * estimate_)
    for (const auto& h : count_harmonics(forms_, size_, bottom, trace_))
      below += h.multiplicity() * h.counted;
  for (const auto& h : harmonics_) counted += h.multiplicity() * h.counted;
  return counted - below > static_cast<std::int64_t>(wanted()) + 1;
}

void MaterialSolve::heed_time() const {
  if (options_.time.passed()) options_.time.refuse();
}

void MaterialSolve::count(const HarmonicForms& section) {
  forms_ = in_material(section, material_);
  for (;;) {
    heed_time();
    harmonics_ = count_harmonics(forms_, size_, std::max(top_, lowest_count * estimate_), trace_);
    if (top_ >= band_.max_frequency || enough()) return;
    top_ = std::min(band_.max_frequency, 1.5 * top_);
  }
}

void MaterialSolve::solve() {
  const double counted_at = std::max(top_, lowest_count * estimate_);
  for (auto& harmonic : harmonics_) {
    // n = 0 and 1 have rigid motions to recognise even where nothing else is below the top.
    if (harmonic.counted == 0 && harmonic.n > 1) continue;
    heed_time();
    solve_harmonic(forms_, counted_at, estimate_, options_.tolerance, harmonic, trace_);
  }
  list();
}

void MaterialSolve::list() {
  const core::ScopedTimer timer(trace_.stages["extract"]);
  found_.clear();
  for (std::size_t h = 0; h < harmonics_.size(); ++h) {
    const auto& harmonic = harmonics_[h];
    const auto kept = std::min<std::int64_t>(harmonic.counted, harmonic.vectors.cols());
    const auto values = rayleigh_quotients(forms_, harmonic.n, harmonic.vectors.leftCols(kept));
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double eigenvalue = values[k] * forms_.scales.eigenvalue();
      for (int twin = 0; twin < harmonic.multiplicity(); ++twin)
        found_.push_back({eigenvalue, h, k, twin == 1, 0});
    }
  }
  std::stable_sort(found_.begin(), found_.end(),
                   [](const Found& a, const Found& b) { return a.eigenvalue < b.eigenvalue; });
}

double MaterialSolve::estimate_errors(const HarmonicForms& finer_section, double saturation) {
  const core::ScopedTimer timer(trace_.stages["estimate"]);
  const HarmonicForms finer = in_material(finer_section, material_);
  double worst = 0;
  for (std::size_t h = 0; h < harmonics_.size(); ++h) {
    const auto& coarse = harmonics_[h];
    if (coarse.counted == 0) continue;
    heed_time();
    const auto values = next_order_values(finer, forms_, coarse, estimate_);
    std::vector<Found*> own;
    for (auto& mode : found_)
      if (mode.harmonic == h) own.push_back(&mode);
    // Ascending: pairs follow each other.
    for (std::size_t k = 0; k < own.size(); ++k) {
      const auto place = k / static_cast<std::size_t>(coarse.multiplicity());
      own[k]->pitch_error =
          place < values.size()
              ? saturation *
                    cents_between(own[k]->eigenvalue, values[place] * finer.scales.eigenvalue())
              : std::numeric_limits<double>::quiet_NaN();
      worst = std::max(worst, own[k]->pitch_error);
    }
  }
  return worst;
}

int MaterialSolve::select() {
  inside_.clear();
  std::vector<double> ascending;
  auto maximum = wanted();
  for (const auto& mode : found_) {
    if (mode.frequency() < band_.min_frequency) continue;
    if (mode.frequency() > band_.max_frequency) break;
    maximum += mode.frequency() < band_.bottom();
    inside_.push_back(mode);
    ascending.push_back(mode.eigenvalue);
  }
  kept_ = modes::whole_clusters(ascending, maximum);
  int highest = 0;
  for (std::size_t k = 0; k < kept_; ++k)
    highest = std::max(highest, harmonics_[inside_[k].harmonic].n);
  return highest;
}

modes::Modes MaterialSolve::modes_on(const TurnedSurface& surface) const {
  const core::ScopedTimer timer(trace_.stages["extract"]);
  modes::Modes modes;
  modes.mass = mass_of(forms_);
  modes.surface = surface.surface();
  const auto rows = static_cast<Eigen::Index>(kept_);
  const std::vector<modes::NodeRing> rings = surface.rings();
  modes::ModeShapes::Rows amplitudes(rows, 3 * static_cast<Eigen::Index>(rings.size()));
  std::vector<modes::CircumferentialWave> waves;
  modes.kinetic_fraction = modes.strain_fraction = Eigen::MatrixXd::Ones(rows, 1);
  const auto& scales = forms_.scales;
  const double to_si = 1 / std::sqrt(scales.density * std::pow(scales.length, 3));
  for (std::size_t k = 0; k < kept_; ++k) {
    const auto& mode = inside_[k];
    const auto& harmonic = harmonics_[mode.harmonic];
    modes.eigenvalues.push_back(mode.eigenvalue);
    modes.residuals.push_back(harmonic.residuals[mode.pair]);
    waves.push_back({harmonic.n, mode.turned ? 1 : 0});
    if (options_.estimate_errors) modes.pitch_errors.push_back(mode.pitch_error);
    const Eigen::VectorXd shape =
        surface.amplitudes(harmonic.vectors.col(static_cast<Eigen::Index>(mode.pair)));
    amplitudes.row(static_cast<Eigen::Index>(k)) =
        (eigen::leading_sign(shape) * to_si * shape).cast<float>().transpose();
  }
  modes.shapes = modes::ModeShapes(std::move(amplitudes), rings, std::move(waves));
  certify(modes);
  return modes;
}

void MaterialSolve::certify(modes::Modes& modes) const {
  auto& certificate = modes.certificate;
  certificate.min_frequency = band_.min_frequency;
  certificate.max_frequency = band_.max_frequency;
  certificate.components = 1;
  certificate.unknowns = 3 * static_cast<std::int64_t>(forms_.mesh.nodes.size());
  double verified = std::numeric_limits<double>::infinity();
  std::int64_t missing = 0;
  // That of harmonics with modes enough; small ones are solved densely.
  certificate.eigen_solver = modes::EigenSolver::dense;
  for (const Harmonic& h : harmonics_) {
    if (!h.values.empty() && h.solver != modes::EigenSolver::dense)
      certificate.eigen_solver = h.solver;
  }
  const double top = forms_.scales.from_frequency(top_);
  for (const auto& h : harmonics_) {
    certificate.rigid_modes += static_cast<int>(h.multiplicity()) * h.rigid;
    certificate.orthonormality = std::max(certificate.orthonormality, h.orthonormality);
    if (!std::isfinite(h.verified_below)) continue;
    verified = std::min(verified, forms_.scales.to_frequency(h.verified_below));
    const auto below =
        std::count_if(h.values.begin(), h.values.end(), [top](double v) { return v < top; });
    missing += h.multiplicity() * std::max<std::int64_t>(0, h.counted - below);
  }
  if (!modes.residuals.empty())
    certificate.max_residual = *std::max_element(modes.residuals.begin(), modes.residuals.end());
  certificate.modes_in_band = static_cast<std::int64_t>(inside_.size()) + missing;
  certificate.modes_found = static_cast<std::int64_t>(kept_);
  certificate.count_verified = top_ >= band_.max_frequency;
  certificate.complete =
      certificate.count_verified && certificate.modes_found == certificate.modes_in_band;
  certificate.complete_to_hz = std::min({verified, top_, band_.max_frequency});
  if (kept_ < inside_.size()) {
    const double last = inside_[kept_ - 1].eigenvalue, next = inside_[kept_].eigenvalue;
    certificate.complete_to_hz =
        std::min(certificate.complete_to_hz, std::sqrt((last + next) / 2) / (2 * pi));
  }
}

}  // namespace carillon::solvers::axisymmetric
