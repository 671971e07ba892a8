#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "solve.hpp"

namespace carillon::test {

/// A free isotropic body whose frequencies a table of tests' data lists.
struct ReferenceBody {
  std::string name;
  std::string table;  ///< below reference_modes/
  solvers::elements::Elastic material;
  /// Meshes of three sizes, coarse to fine, with the nodes of the next order.
  std::function<solvers::mesh::TetMesh(int order, int size)> mesh;
};

/// Every table that describes a free isotropic body. The others are not of this kind:
/// beam_free_free and rod_free_free (theory of beams and rods), lame_modes_square_section (single
/// modes, without the others between), plate_ss_faces_NAFEMS_FV52 and published_nafems (supported),
/// published_rus_SrTiO3_cubic (anisotropic), tetfem_box (frequencies of one discrete mesh).
const std::vector<ReferenceBody>& reference_bodies();
const ReferenceBody& reference_body(const std::string& name);

/// Frequencies of a table, ascending, repeated ones as often as they come; all of them below the
/// last are known.
std::vector<double> table_frequencies(const std::string& table);

/// Estimated against true pitch errors of a body's modes.
struct Effectivity {
  std::size_t compared = 0;  ///< modes off by more than 0.2 cents
  double minimum = 0, median = 0, maximum = 0;
  double worst_error = 0;  ///< that the truth allows [cents]
  std::string complaint;   ///< modes outside [0.7, 2.5], in words
};

/// The k-th mode is compared with the k-th of the table.
/// @param doubts  how much too high each true frequency may be [cents]; none where empty. An
///                estimate then counts as true if it is for one of the errors that this allows.
Effectivity measure_effectivity(const solvers::modes::Modes& modes, std::span<const double> truth,
                                std::span<const double> doubts = {});

}  // namespace carillon::test
