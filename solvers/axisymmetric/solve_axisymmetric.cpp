#include "solvers/axisymmetric/solve_axisymmetric.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "solvers/axisymmetric/detail/harmonic_search.hpp"
#include "solvers/axisymmetric/detail/harmonic_surface.hpp"
#include "solvers/eigen/select.hpp"

namespace carillon::solvers::axisymmetric {
namespace {

using std::numbers::pi;
/// Cells to begin with: their order, and the largest wave number times their side over the order.
struct FirstCells {
  int order;
  double waves;
};
/// Errors near 0.1 cents, and near 0.001.
constexpr FirstCells usual_cells = {4, 1}, fine_cells = {6, 2.0 / 3};
/// Targets below this begin with fine cells [cents].
constexpr double fine_target = 0.5;
constexpr int max_refinements = 2;
/// The next order misses a part of what it changes: 3 to 16 % in the families.
constexpr double saturation = 1.15;
/// Bodies with more modes than this in the band are not solved far beyond max_modes.
constexpr double many_modes = 300;
/// Far below the first mode an inertia count drowns in rounding.
constexpr double lowest_count = 0.05;

void require(bool holds, const std::string& message) {
  if (!holds) throw core::InputError(message);
}

void check_input(const mesh::Meridian& meridian, const elements::Elastic& m,
                 const modes::Band& band, const AxisymmetricOptions& axisymmetric) {
  require(!meridian.blocks.empty(), "the section is empty");
  require(axisymmetric.order == 0 || (axisymmetric.order >= 2 && axisymmetric.order <= 14),
          fmt::format("cells of order {} are not known; 2 to 14 are", axisymmetric.order));
  elements::check_elastic(m);
  if (m.anisotropy)
    throw core::InputError("the axisymmetric solver knows isotropic materials alone",
                           "solve the body in tetrahedra");
  eigen::check_band(band);
}

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

/// One discretisation of the body and the frequency up to which its modes are sought.
struct Attempt {
  HarmonicForms forms;
  double top = 0;  ///< [Hz]
  std::vector<Harmonic> harmonics;

  std::int64_t counted() const {
    std::int64_t sum = 0;
    for (const auto& h : harmonics) sum += h.multiplicity() * h.counted;
    return sum;
  }
};

/// A mode of the whole body: one of a harmonic's pairs, or the one turned against it.
struct Found {
  double eigenvalue;  ///< [rad^2/s^2]
  std::size_t harmonic, pair;
  bool turned;
  double pitch_error;  ///< [cents]

  double frequency() const { return std::sqrt(eigenvalue) / (2 * pi); }
};

double cents_between(double eigenvalue, double other) {
  return 0.5 * std::abs(core::cents(eigenvalue / other));
}

class AxisymmetricSolve {
 public:
  AxisymmetricSolve(const mesh::Meridian& meridian, const elements::Elastic& material,
                    const eigen::SolveOptions& options, const AxisymmetricOptions& axisymmetric,
                    core::Trace& trace)
      : meridian_(meridian),
        material_(material),
        options_(options),
        axisymmetric_(axisymmetric),
        trace_(trace),
        size_(mesh::measure(meridian)),
        estimate_(estimate_first_frequency(size_, material)),
        first_(axisymmetric.pitch_target > 0 && axisymmetric.pitch_target < fine_target
                   ? fine_cells
                   : usual_cells),
        order_(axisymmetric.order > 0 ? axisymmetric.order : first_.order) {}

  modes::Modes run() {
    auto attempt = count(first_top());
    const bool refine =
        options_.estimate_errors && axisymmetric_.cell == 0 && axisymmetric_.pitch_target > 0;
    double before = std::numeric_limits<double>::infinity();
    for (int step = 0;; ++step) {
      solve(attempt);
      auto found = list(attempt);
      if (options_.estimate_errors) estimate_errors(attempt, found);
      double worst = 0;
      for (const auto& mode : found) worst = std::max(worst, mode.pitch_error);
      const bool gains = worst < before / 2;
      if (!refine || worst <= axisymmetric_.pitch_target || step == max_refinements || !gains) {
        return select(attempt, found);
      }
      before = worst;
      if (step == 0) {
        order_ += 2;
      } else {
        // Halving cells that are larger than the section's parts would change nothing.
        cell_ = std::min(cell_, mesh::longest_side(meridian_)) / 2;
      }
      attempt = count_with_cell(attempt.top);
    }
  }

 private:
  std::size_t wanted() const { return static_cast<std::size_t>(options_.band.max_modes); }

  /// The band's top, or a lower frequency below which there should be twice the modes wanted.
  double first_top() const {
    const double top = options_.band.max_frequency;
    const auto expected = [this](double f) { return expected_modes(size_, material_, f); };
    const double below = expected(options_.band.bottom());
    const double enough = 2 * static_cast<double>(wanted()) + below;
    if (expected(top) <= std::max(many_modes + below, 2 * enough)) return top;
    double low = options_.band.bottom(), high = top;
    for (int i = 0; i < 60; ++i) {
      const double middle = (low + high) / 2;
      (expected(middle) < enough ? low : high) = middle;
    }
    return std::min(top, std::max(high, 2 * estimate_));
  }

  /// Counts below `top`, and higher up while too few modes lie there.
  Attempt count(double top) {
    for (;;) {
      cell_ = axisymmetric_.cell > 0 ? axisymmetric_.cell : cell_for(top);
      auto attempt = count_with_cell(top);
      if (top >= options_.band.max_frequency || enough(attempt)) return attempt;
      top = std::min(options_.band.max_frequency, 1.5 * top);
    }
  }

  /// Whether max_modes lie above the bottom of the band; those below it are few beside the modes
  /// that are counted, or the frequency grows further.
  bool enough(const Attempt& attempt) const {
    std::int64_t below = 0;
    const double bottom = options_.band.bottom();
    if (bottom > lowest_count * estimate_) {
      for (const auto& h : count_harmonics(attempt.forms, size_, bottom, trace_)) {
        below += h.multiplicity() * h.counted;
      }
    }
    return attempt.counted() - below > static_cast<std::int64_t>(wanted()) + 1;
  }

  double cell_for(double top) const {
    return first_.waves * order_ / largest_wave_number(size_, material_, std::max(top, estimate_));
  }

  HarmonicForms forms_of_order(int order) const {
    mesh::MeridianMesh mesh;
    {
      const core::ScopedTimer timer(trace_.stages["mesh"]);
      mesh = mesh::mesh_meridian(meridian_, order, cell_);
    }
    const core::ScopedTimer timer(trace_.stages["assemble"]);
    return harmonic_forms(std::move(mesh), material_);
  }

  Attempt count_with_cell(double top) const {
    Attempt attempt{forms_of_order(order_), top, {}};
    attempt.harmonics =
        count_harmonics(attempt.forms, size_, std::max(top, lowest_count * estimate_), trace_);
    return attempt;
  }

  void solve(Attempt& attempt) const {
    const double counted_at = std::max(attempt.top, lowest_count * estimate_);
    for (auto& harmonic : attempt.harmonics) {
      // n = 0 and 1 have rigid motions to recognise even where nothing else is below the top.
      if (harmonic.counted == 0 && harmonic.n > 1) continue;
      solve_harmonic(attempt.forms, counted_at, estimate_, options_.tolerance, harmonic, trace_);
    }
  }

  /// Every mode that was counted, ascending.
  std::vector<Found> list(Attempt& attempt) const {
    const core::ScopedTimer timer(trace_.stages["extract"]);
    std::vector<Found> out;
    for (std::size_t h = 0; h < attempt.harmonics.size(); ++h) {
      auto& harmonic = attempt.harmonics[h];
      const auto kept = std::min<std::int64_t>(harmonic.counted, harmonic.vectors.cols());
      const auto values =
          rayleigh_quotients(attempt.forms, harmonic.n, harmonic.vectors.leftCols(kept));
      for (std::size_t k = 0; k < values.size(); ++k) {
        const double eigenvalue = values[k] * attempt.forms.scales.eigenvalue();
        for (int twin = 0; twin < harmonic.multiplicity(); ++twin) {
          out.push_back({eigenvalue, h, k, twin == 1, 0});
        }
      }
    }
    std::stable_sort(out.begin(), out.end(),
                     [](const Found& a, const Found& b) { return a.eigenvalue < b.eigenvalue; });
    return out;
  }

  /// Compares with the same cells at the next order.
  void estimate_errors(const Attempt& attempt, std::vector<Found>& found) const {
    const core::ScopedTimer timer(trace_.stages["estimate"]);
    const auto finer = forms_of_order(order_ + 1);
    for (std::size_t h = 0; h < attempt.harmonics.size(); ++h) {
      const auto& coarse = attempt.harmonics[h];
      if (coarse.counted == 0) continue;
      const auto values = next_order_values(finer, attempt.forms, coarse, estimate_);
      std::vector<Found*> own;
      for (auto& mode : found) {
        if (mode.harmonic == h) own.push_back(&mode);
      }
      // Ascending: pairs follow each other.
      for (std::size_t k = 0; k < own.size(); ++k) {
        const auto place = k / static_cast<std::size_t>(coarse.multiplicity());
        own[k]->pitch_error =
            place < values.size()
                ? saturation *
                      cents_between(own[k]->eigenvalue, values[place] * finer.scales.eigenvalue())
                : std::numeric_limits<double>::quiet_NaN();
      }
    }
  }

  modes::Modes select(const Attempt& attempt, const std::vector<Found>& found) const {
    const core::ScopedTimer timer(trace_.stages["extract"]);
    const auto& band = options_.band;
    std::vector<Found> inside;
    std::vector<double> ascending;
    auto maximum = wanted();
    for (const auto& mode : found) {
      if (mode.frequency() < band.min_frequency) continue;
      if (mode.frequency() > band.max_frequency) break;
      maximum += mode.frequency() < band.bottom();
      inside.push_back(mode);
      ascending.push_back(mode.eigenvalue);
    }
    const auto in_band = inside.size();
    const auto kept = modes::whole_clusters(ascending, maximum);

    modes::Modes modes;
    modes.mass = mass_of(attempt.forms);
    int highest = 0;
    for (std::size_t k = 0; k < kept; ++k) {
      highest = std::max(highest, attempt.harmonics[inside[k].harmonic].n);
    }
    const TurnedSurface surface(attempt.forms.mesh, highest);
    modes.surface = surface.surface();
    const auto rows = static_cast<Eigen::Index>(kept);
    modes.shapes.resize(rows, 3 * static_cast<Eigen::Index>(modes.surface.nodes.size()));
    modes.kinetic_fraction = modes.strain_fraction = Eigen::MatrixXd::Ones(rows, 1);
    const auto& scales = attempt.forms.scales;
    const double to_si = 1 / std::sqrt(scales.density * std::pow(scales.length, 3));
    for (std::size_t k = 0; k < kept; ++k) {
      const auto& mode = inside[k];
      const auto& harmonic = attempt.harmonics[mode.harmonic];
      modes.eigenvalues.push_back(mode.eigenvalue);
      modes.residuals.push_back(harmonic.residuals[mode.pair]);
      modes.harmonics.push_back(harmonic.n);
      if (options_.estimate_errors) modes.pitch_errors.push_back(mode.pitch_error);
      Eigen::VectorXd shape = surface.evaluate(
          harmonic.n, harmonic.vectors.col(static_cast<Eigen::Index>(mode.pair)), mode.turned);
      const double largest = shape.cwiseAbs().maxCoeff();
      const auto leading = std::find_if(shape.begin(), shape.end(), [largest](double v) {
        return std::abs(v) >= (1 - 1e-6) * largest;
      });
      const double sign = leading != shape.end() && *leading < 0 ? -to_si : to_si;
      modes.shapes.row(static_cast<Eigen::Index>(k)) = (sign * shape).cast<float>().transpose();
    }
    certify(attempt, inside, in_band, kept, modes);
    return modes;
  }

  void certify(const Attempt& attempt, const std::vector<Found>& inside, std::size_t in_band,
               std::size_t kept, modes::Modes& modes) const {
    const auto& band = options_.band;
    auto& certificate = modes.certificate;
    certificate.min_frequency = band.min_frequency;
    certificate.max_frequency = band.max_frequency;
    certificate.components = 1;
    certificate.unknowns = 3 * static_cast<std::int64_t>(attempt.forms.mesh.nodes.size());
    double verified = std::numeric_limits<double>::infinity();
    std::int64_t missing = 0;
    const bool all_dense =
        std::all_of(attempt.harmonics.begin(), attempt.harmonics.end(), [](const Harmonic& h) {
          return h.values.empty() || h.solver == modes::EigenSolver::dense;
        });
    certificate.eigen_solver =
        all_dense ? modes::EigenSolver::dense : modes::EigenSolver::block_lanczos;
    for (const auto& h : attempt.harmonics) {
      certificate.rigid_modes += static_cast<int>(h.multiplicity()) * h.rigid;
      certificate.orthonormality = std::max(certificate.orthonormality, h.orthonormality);
      if (std::isfinite(h.verified_below)) {
        verified = std::min(verified, attempt.forms.scales.to_frequency(h.verified_below));
        const double top = attempt.forms.scales.from_frequency(attempt.top);
        const auto below =
            std::count_if(h.values.begin(), h.values.end(), [top](double v) { return v < top; });
        missing += h.multiplicity() * std::max<std::int64_t>(0, h.counted - below);
      }
    }
    if (!modes.residuals.empty()) {
      certificate.max_residual = *std::max_element(modes.residuals.begin(), modes.residuals.end());
    }
    certificate.modes_in_band = static_cast<std::int64_t>(in_band) + missing;
    certificate.modes_found = static_cast<std::int64_t>(kept);
    certificate.count_verified = attempt.top >= band.max_frequency;
    certificate.complete =
        certificate.count_verified && certificate.modes_found == certificate.modes_in_band;
    certificate.complete_to_hz = std::min({verified, attempt.top, band.max_frequency});
    if (kept < in_band) {
      const double last = inside[kept - 1].eigenvalue, next = inside[kept].eigenvalue;
      certificate.complete_to_hz =
          std::min(certificate.complete_to_hz, std::sqrt((last + next) / 2) / (2 * pi));
    }
  }

  const mesh::Meridian& meridian_;
  const elements::Elastic& material_;
  const eigen::SolveOptions& options_;
  const AxisymmetricOptions& axisymmetric_;
  core::Trace& trace_;
  mesh::MeridianSize size_;
  double estimate_;  ///< of the lowest flexible frequency [Hz]
  FirstCells first_;
  int order_;
  double cell_ = 0;
};

}  // namespace

modes::Modes solve_axisymmetric(const mesh::Meridian& meridian, const elements::Elastic& material,
                                const eigen::SolveOptions& options,
                                const AxisymmetricOptions& axisymmetric, core::Trace& trace) {
  check_input(meridian, material, options.band, axisymmetric);
  return AxisymmetricSolve(meridian, material, options, axisymmetric, trace).run();
}

}  // namespace carillon::solvers::axisymmetric
