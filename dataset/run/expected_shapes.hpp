#pragma once

#include <vector>

#include "dataset/plan/expected_mesh.hpp"
#include "mpi/task_board.hpp"

namespace carillon::dataset::run {

/// A surface with mode shapes, as a modes file has it.
struct ExpectedSurface {
  double nodes = 0, faces = 0;
  int order = 3;
  double rows = 0;        ///< nodes, or rings, that shapes have values at
  double compressed = 1;  ///< fraction of shapes that compressing leaves
};

/// What a shape's modes task should come to, before anything is meshed. The size of a tuned shape
/// is a guess.
struct ExpectedShape {
  plan::ExpectedObject object{};    ///< as it is meshed first
  solvers::pitch::MeshSize last{};  ///< the mesh that its modes are kept on
  int probes = 0;                   ///< solves of the hardest set before that mesh
  std::vector<double> modes{};      ///< of each mode set
  bool about_axis = false;          ///< solved by its section, without a mesh
  ExpectedSurface surface{};

  /// Of the largest set.
  double max_modes() const;
  /// Of all sets.
  double mean_modes() const;
};

/// In the order of the plan's shapes.
std::vector<ExpectedShape> expected_shapes(const configuration::BuildConfig& config,
                                           const plan::BuildPlan& plan);

/// Processor seconds of its solves and of starting the mesher, views left out.
double modes_seconds(const ExpectedShape& shape);

}  // namespace carillon::dataset::run
