#include "solvers/pitch/expected_costs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/elements/lagrange.hpp"
#include "solvers/mesh/sizing.hpp"
#include "solvers/pitch/pitch_target.hpp"

namespace carillon::solvers::pitch {

namespace {

/// [byte] of K and M.
double matrix_bytes(const MeshSize& mesh) {
  return 12 * 3 * mesh.unknowns() * (20 + 25 * mesh.order);
}

/// One of the parts whose images a mesh is.
MeshSize part_of(const MeshSize& mesh) {
  MeshSize part = mesh;
  for (double* count : {&part.elements, &part.vertices, &part.edges, &part.faces})
    *count /= mesh.images;
  part.images = 1;
  return part;
}

/// [byte] of judging the modes by elements of the next order: its element matrices, fields of as
/// many modes as are judged at a time, and local solves, or, where elements are wide against a thin
/// wall, a factor of that order (solvers/eigen/pitch_error.hpp). Every rank of a group has whole
/// fields.
double judging_bytes(const MeshSize& mesh, double modes, int ranks) {
  constexpr double wide = 3.5, max_at_once = 128, fields_each = 9;
  const MeshSize finer = resized(mesh, mesh.order + 1, 1);
  const double nodes = elements::nodes_per_tetrahedron(finer.order);
  const double kept = 80 * nodes * nodes * mesh.elements;
  const double fields = ranks * fields_each * 8 * finer.unknowns() * std::min(modes, max_at_once);
  const double local = 4 * 9 * nodes * nodes * mesh.elements;
  const bool factored = mesh.element_size > wide * mesh.thickness;
  return 1.15 * (kept + fields) +
         (factored ? 1.3 * factor_memory(finer) + matrix_bytes(finer) : local);
}

}  // namespace

// Cells of a wall, or of a solid, are each cut into six tetrahedra.
MeshSize expected_mesh(const mesh::ShapeExtent& body, const mesh::MeshOptions& options,
                       std::optional<double> curve_cells) {
  const double midsurface = body.volume / body.thickness;
  const double cell = std::max(mesh::wanted_cell(options, body.thickness), 1e-6 * body.thickness);
  const double layers = mesh::layers_through(body.thickness, cell, options);
  double columns = std::max(1.0, midsurface / (cell * cell));
  if (options.element_size > 0) {
    columns += curve_cells.value_or(0);
  } else {
    // Bodies from files take a few times as many.
    const mesh::SizeBudget budget = mesh::size_budget(options.order);
    const double fewest = static_cast<double>(budget.min) * (curve_cells ? 1 : 2);
    const double largest = static_cast<double>(budget.max) * (curve_cells ? 1 : 3);
    columns *= std::clamp(6 * columns * layers, fewest, largest) / (6 * columns * layers);
  }
  columns = std::min(columns, static_cast<double>(options.max_elements) / (6 * layers));
  MeshSize mesh;
  mesh.order = options.order;
  mesh.element_size = std::sqrt(2 * midsurface / columns);
  mesh.thickness = body.thickness;
  mesh.elements = 6 * columns * layers;
  mesh.vertices = columns * (layers + 1);
  mesh.faces = 2 * mesh.elements + 2 * columns;
  mesh.edges = std::max(0.0, mesh.vertices + mesh.faces - mesh.elements - 1);
  mesh.images = std::exp2(body.mirror_planes + (body.is_halved && layers > 1 ? 1 : 0));
  return mesh;
}

MeshSize expected_mesh_of_file(double bytes, const mesh::ShapeExtent& body, int order) {
  MeshSize mesh;
  mesh.order = order;
  mesh.thickness = body.thickness;
  mesh.elements = std::max(10.0, bytes / 40);
  mesh.vertices = mesh.elements / 4;
  mesh.faces = 2.2 * mesh.elements;
  mesh.edges = mesh.vertices + mesh.faces - mesh.elements;
  mesh.element_size = 2 * std::cbrt(6 * body.volume / mesh.elements);
  return mesh;
}

double expected_error(const MeshSize& mesh, double wave_number) {
  constexpr double cents = 1.8, exponent = 2.5;
  constexpr int usual_order = 3;
  const double usual = cents * std::pow(wave_number * mesh.element_size, exponent);
  return predicted_error(usual, usual_order, mesh.order, 1);
}

MeshSize expected_refinement(const MeshSize& mesh, double error, double cents,
                             std::int64_t max_unknowns) {
  if (cents <= 0 || error <= trusted_share * cents || mesh.order > 3) return mesh;
  // Meshers make cells in whole numbers, smaller than they are asked for.
  constexpr double made = 0.9;
  const double goal = aimed_error(cents, error);
  MeshSize best = mesh;
  double best_cost = std::numeric_limits<double>::infinity(), best_error = error;
  for (int order = 2; order <= 4; ++order) {
    for (int sixth = finest_sixth; sixth <= coarsest_sixth; ++sixth) {
      const double factor = std::exp2(sixth / 6.0);
      const MeshSize next = resized(mesh, order, made * factor);
      if (next.unknowns() > static_cast<double>(max_unknowns)) continue;
      const double then = std::max(goal, predicted_error(error, mesh.order, order, factor));
      const double cost = relative_cost(next);
      if (then > best_error || (then == best_error && cost >= best_cost)) continue;
      best = next;
      best_cost = cost;
      best_error = then;
    }
  }
  return best;
}

double mesh_seconds(const MeshSize& mesh) {
  constexpr double libraries = 0.25, element = 2e-5;
  return libraries + element * mesh.elements;
}

double solve_seconds(const MeshSize& mesh, const ExpectedSets& sets) {
  constexpr double smallest = 0.08;  // ordering and counting, however small the body
  // Eight classes of an eighth take 0.29 of the whole's time, four 0.28 to 0.43, two 0.64.
  const double solve = 5e-6 * std::pow(mesh.unknowns(), 1.3) * std::pow(mesh.layers(), 0.35) *
                       (sets.modes + 110) / 110 * std::pow(mesh.images, -0.6);
  // Sets from a basis cost a tenth of a solve.
  return smallest * sets.solves + (sets.solves + 0.1 * (sets.sets - sets.solves)) * solve;
}

double solve_memory(const MeshSize& mesh, const ExpectedSets& sets, int ranks,
                    double memory_limit) {
  constexpr double libraries = 6e7;  // that the first solve wakes
  // Each rank has a class of its own while there are enough.
  const MeshSize part = part_of(mesh);
  const double classes = std::min<double>(ranks, mesh.images), n = part.unknowns();
  const double modes = sets.modes / mesh.images;
  const int ranks_each = std::max(1, static_cast<int>(ranks / mesh.images));
  const double solving = 1.3 * factor_memory(part) + 8 * n * (5 * modes + 80);
  const double others = 12 * mesh.unknowns() * sets.modes * (sets.sets - 1);
  const double all =
      classes * (matrix_bytes(part) + std::max(solving, judging_bytes(part, modes, ranks_each))) +
      others;
  return ranks * libraries + std::min(all, memory_limit);
}

}  // namespace carillon::solvers::pitch
