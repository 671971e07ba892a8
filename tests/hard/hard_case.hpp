#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "../solvers/solve.hpp"
#include "solvers/eigen/search.hpp"

namespace carillon::test {

/// What a mode set of a hard case must still hold: a complete certificate, six rigid modes for each
/// component, shapes without NaN, and pitch errors that are finite and not negative (where there
/// are any).
/// @param residual  most that certificate.max_residual may be
void expect_sound(const solvers::modes::Modes& modes, double residual = 1e-8);

/// Every mode below the band's top was counted and is in the set.
void expect_complete(const solvers::modes::Modes& modes);

/// All modes in a band, with one material for each region.
solvers::modes::Modes modes_in(
    const solvers::mesh::TetMesh& mesh, const std::vector<solvers::elements::Elastic>& regions,
    const solvers::modes::Band& band,
    solvers::modes::EigenSolver solver = solvers::modes::EigenSolver::block_lanczos);

/// Largest distance in cents between the first modes of two sets, or of a set and a truth.
double worst_cents(const std::vector<double>& found, const std::vector<double>& truth,
                   std::size_t count);

/// Box of cells of six tetrahedra whose halves meet in a layer of slivers: the diagonals of the two
/// sides cross, and each gap between them, opened by bending the layer into a saddle, holds one
/// flat tetrahedron. First order.
/// @param cells     along each axis; the layer lies on the plane below cell `middle` of the third
/// @param dihedral  smallest dihedral angle of the slivers [degree]
solvers::mesh::TetMesh sliver_mesh(const Vec3& sides, const std::array<int, 3>& cells, int middle,
                                   double dihedral, int order);

/// Box of cells that each are cut into 24 tetrahedra about their middle: with equal sides and cells
/// the mesh has every symmetry of the cube, so it splits no repeated mode.
solvers::mesh::TetMesh symmetric_box_mesh(const Vec3& sides, const std::array<int, 3>& cells,
                                          int order);

/// Number of modes in each cluster of ascending values that lie within `gap` (relative) of the one
/// before.
std::vector<int> cluster_sizes(const std::vector<double>& ascending, double gap);

/// Text of an MSH 2.2 file of the tetrahedra (order 1 or 2), one physical group for each region.
std::string msh_text(const solvers::mesh::TetMesh& mesh);

}  // namespace carillon::test
