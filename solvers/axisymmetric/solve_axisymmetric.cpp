#include "solvers/axisymmetric/solve_axisymmetric.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "solvers/axisymmetric/detail/harmonic_surface.hpp"
#include "solvers/axisymmetric/detail/material_solve.hpp"
#include "solvers/eigen/select.hpp"

namespace carillon::solvers::axisymmetric {
namespace {

/// Cells to begin with: their order, and the largest wave number times their side over the order.
struct FirstCells {
  int order;
  double waves;
};
/// Errors near 0.1 cents, and near 0.001.
constexpr FirstCells usual_cells = {4, 1}, fine_cells = {6, 2.0 / 3};
/// What the next order changes, with what it misses itself: 3 to 24 % in the families, up to a half
/// where corners turn inward.
constexpr double usual_saturation = 1.25, inward_saturation = 1.5;
/// Targets below this begin with fine cells [cents].
constexpr double fine_target = 0.5;
constexpr int max_refinements = 2;
/// Of cells that an outline's parts make far smaller than waves ask for.
constexpr int low_order = 2;

void require(bool holds, const std::string& message) {
  if (!holds) throw core::InputError(message);
}

void check_input(const mesh::Meridian& meridian, std::span<const MaterialBand> wanted,
                 const AxisymmetricOptions& axisymmetric) {
  require(!meridian.blocks.empty(), "the section is empty");
  require(axisymmetric.order == 0 || (axisymmetric.order >= 2 && axisymmetric.order <= 14),
          fmt::format("cells of order {} are not known; 2 to 14 are", axisymmetric.order));
  for (const MaterialBand& one : wanted) {
    elements::check_elastic(one.material);
    if (one.material.anisotropy)
      throw core::InputError("the axisymmetric solver knows isotropic materials alone",
                             "solve the body in tetrahedra");
    eigen::check_band(one.band);
  }
}

/// A body in all its materials, on one section after the other.
class SharedSections {
 public:
  SharedSections(const mesh::Meridian& meridian, std::span<const MaterialBand> wanted,
                 const eigen::SolveOptions& options, const AxisymmetricOptions& axisymmetric,
                 core::Trace& trace)
      : meridian_(meridian),
        axisymmetric_(axisymmetric),
        trace_(trace),
        estimates_(options.estimate_errors),
        first_(axisymmetric.pitch_target > 0 && axisymmetric.pitch_target < fine_target
                   ? fine_cells
                   : usual_cells),
        order_(axisymmetric.order > 0 ? axisymmetric.order : first_.order) {
    const mesh::MeridianSize size = mesh::measure(meridian);
    for (const MaterialBand& one : wanted)
      solves_.emplace_back(size, one.material, one.band, options, trace);
    // Parts of an outline of many points are small cells already, and serve usual targets as such.
    if (axisymmetric.order == 0 && refines() && axisymmetric.pitch_target >= fine_target &&
        2 * nodes_of_order(low_order) < nodes_of_order(order_))
      order_ = low_order;
  }

  /// Of the first section; surfaces of refined ones are about the same.
  ExpectedSection expected() const {
    ExpectedSection out;
    const mesh::MeridianMesh mesh = mesh::mesh_meridian(meridian_, order_, wanted_cell());
    double highest = 0;
    for (const MaterialSolve& one : solves_) {
      out.modes.push_back(one.expected_modes());
      highest = std::max(highest, one.expected_harmonic());
    }
    const TurnedSize surface = expected_surface(mesh, highest);
    out.rings = surface.rings;
    out.surface_nodes = surface.nodes;
    out.surface_faces = surface.faces;
    return out;
  }

  std::vector<modes::Modes> run() {
    count();
    double before = std::numeric_limits<double>::infinity();
    for (int step = 0;; ++step) {
      const double worst = solve();
      const bool gains = worst < before / 2;
      if (!refines() || worst <= axisymmetric_.pitch_target || step == max_refinements || !gains)
        return selected();
      before = worst;
      if (step == 0) {
        order_ += 2;
      } else {
        // Halving cells that are larger than the section's parts would change nothing.
        cell_ = std::min(cell_, mesh::longest_side(meridian_)) / 2;
      }
      section_ = section_of_order(order_);
      for (MaterialSolve& one : solves_) one.count(section_);
    }
  }

 private:
  bool refines() const {
    return estimates_ && axisymmetric_.cell == 0 && axisymmetric_.pitch_target > 0;
  }

  std::size_t nodes_of_order(int order) const {
    return mesh::mesh_meridian(meridian_, order, cell_of_order(order)).nodes.size();
  }

  double wanted_cell() const {
    return axisymmetric_.cell > 0 ? axisymmetric_.cell : cell_of_order(order_);
  }

  /// The cell of an order that the shortest of all waves asks for.
  double cell_of_order(int order) const {
    double shortest = 0;
    for (const MaterialSolve& one : solves_)
      shortest = std::max(shortest, one.largest_wave_number());
    return first_.waves * order / shortest;
  }

  /// Counts on a section that is fine enough for the frequencies up to which it turned out
  /// that modes are to be sought.
  void count() {
    do {
      cell_ = wanted_cell();
      section_ = section_of_order(order_);
      for (MaterialSolve& one : solves_) one.count(section_);
    } while (wanted_cell() < cell_);
  }

  HarmonicForms section_of_order(int order) const {
    mesh::MeridianMesh mesh;
    {
      const core::ScopedTimer timer(trace_.stages["mesh"]);
      mesh = mesh::mesh_meridian(meridian_, order, cell_);
    }
    const core::ScopedTimer timer(trace_.stages["assemble"]);
    return harmonic_forms(std::move(mesh));
  }

  /// @return the worst estimated error [cents]; 0 where none is estimated
  double solve() {
    for (MaterialSolve& one : solves_) one.solve();
    if (!estimates_) return 0;
    const HarmonicForms finer = section_of_order(order_ + 1);
    const double saturation = meridian_.is_graded ? inward_saturation : usual_saturation;
    double worst = 0;
    for (MaterialSolve& one : solves_)
      worst = std::max(worst, one.estimate_errors(finer, saturation));
    return worst;
  }

  std::vector<modes::Modes> selected() {
    int highest = 0;
    for (MaterialSolve& one : solves_) highest = std::max(highest, one.select());
    const TurnedSurface surface(section_.mesh, highest);
    std::vector<modes::Modes> out;
    out.reserve(solves_.size());
    for (const MaterialSolve& one : solves_) out.push_back(one.modes_on(surface));
    return out;
  }

  const mesh::Meridian& meridian_;
  const AxisymmetricOptions& axisymmetric_;
  core::Trace& trace_;
  bool estimates_;
  FirstCells first_;
  int order_;
  double cell_ = 0;
  HarmonicForms section_;  ///< in a material of no consequence
  std::vector<MaterialSolve> solves_;
};

}  // namespace

std::vector<modes::Modes> solve_axisymmetric(const mesh::Meridian& meridian,
                                             std::span<const MaterialBand> wanted,
                                             const eigen::SolveOptions& options,
                                             const AxisymmetricOptions& axisymmetric,
                                             core::Trace& trace) {
  check_input(meridian, wanted, axisymmetric);
  return SharedSections(meridian, wanted, options, axisymmetric, trace).run();
}

ExpectedSection expected_section(const mesh::Meridian& meridian,
                                 std::span<const MaterialBand> wanted,
                                 const AxisymmetricOptions& axisymmetric) {
  check_input(meridian, wanted, axisymmetric);
  const eigen::SolveOptions options;
  core::Trace trace;
  return SharedSections(meridian, wanted, options, axisymmetric, trace).expected();
}

modes::Modes solve_axisymmetric(const mesh::Meridian& meridian, const elements::Elastic& material,
                                const eigen::SolveOptions& options,
                                const AxisymmetricOptions& axisymmetric, core::Trace& trace) {
  const MaterialBand wanted{material, options.band};
  return std::move(
      solve_axisymmetric(meridian, std::span(&wanted, 1), options, axisymmetric, trace).front());
}

}  // namespace carillon::solvers::axisymmetric
