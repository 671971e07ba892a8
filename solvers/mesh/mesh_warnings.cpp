#include "solvers/mesh/mesh_warnings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

namespace carillon::solvers::mesh {
namespace {

constexpr double usual_length = 2, usual_mass = 1000;
constexpr double volume_change = 0.01, filled_area = 0.02;

std::string in_words(double mass) {
  if (mass >= usual_mass) return fmt::format("{:.3g} tonnes", mass / 1000);
  return mass >= 1 ? fmt::format("{:.4g} kg", mass) : fmt::format("{:.4g} g", 1000 * mass);
}

/// The first few of them.
std::string shortened(const std::vector<std::string>& names) {
  constexpr std::size_t shown = 5;
  if (names.size() <= shown) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{}, ...", fmt::join(names.begin(), names.begin() + shown, ", "));
}

}  // namespace

std::string unit_question(const MeshFile& file, double longest, double mass) {
  if (file.length > 0 || (file.unit > 0 && file.unit != 1) || file.any_size) return "";
  if (!(longest > usual_length || mass > usual_mass)) return "";
  return fmt::format(
      "{:.3g} m{}: is the file in millimetres? Say unit: mm, or length: {:.4g} mm; any_size: true "
      "where it is that large",
      longest, mass > 0 ? " and " + in_words(mass) : "", longest);
}

std::vector<std::string> mesh_warnings(const MeshFile& file, const MeshResult& mesh, double mass) {
  std::vector<std::string> warnings;
  const double volume = mesh.quality.volume;
  const double density = mass / volume;
  const double longest = bounding_box(mesh.mesh.nodes).longest_side();
  if (std::string question = unit_question(file, longest, mass); !question.empty())
    warnings.push_back(std::move(question));
  const RepairReport& repair = mesh.repair;
  if (!repair.joined.empty()) {
    warnings.push_back(fmt::format(
        "{} nodes of the file are one body: {}; one of them alone is node: {}, each for itself "
        "nodes: each",
        repair.joined.size(), shortened(repair.joined), repair.joined.front()));
  }
  if (std::abs(repair.volume_change) > volume_change) {
    warnings.push_back(fmt::format("the repair changed the volume by {:+.1f} %, from {} to {}",
                                   100 * repair.volume_change,
                                   in_words(mass / (1 + repair.volume_change)), in_words(mass)));
  }
  if (repair.filled_area > filled_area) {
    warnings.push_back(fmt::format(
        "holes of {:.3g} % of the surface were filled, so that the body is solid behind them; "
        "where they are openings, close the surface in a modeller or say thickness: 0.003 m",
        100 * repair.filled_area));
  }
  if (repair.wrap_alpha > 0) {
    warnings.push_back(
        fmt::format("the surface could not be mended as it is and was wrapped: what is narrower "
                    "than {:.2g} mm may be closed or rounded, the more so where faces cross",
                    1e3 * repair.wrap_alpha));
  }
  if (repair.swallowed_surfaces > 0) {
    const std::string what =
        repair.swallowed_surfaces == 1
            ? "a closed surface inside of the body looks outward and was"
            : fmt::format("{} closed surfaces inside of the body look outward and were",
                          repair.swallowed_surfaces);
    warnings.push_back(fmt::format(
        "{} taken for solid: {}; meant as cavities, and as cores in them, it would be {}: then "
        "turn the triangles of cavities over",
        what, in_words(mass), in_words(density * (volume - repair.swallowed_volume))));
  }
  if (!follows_surface(mesh.quality, longest, mean_thickness(mesh.mesh))) {
    warnings.push_back(fmt::format(
        "the elements follow the surface within {:.3g} mm and {:+.1f} % of its area; a smaller "
        "element_size keeps more of its detail",
        1e3 * mesh.quality.hausdorff, 100 * mesh.quality.area_error));
  }
  return warnings;
}

}  // namespace carillon::solvers::mesh
