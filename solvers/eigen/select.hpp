#pragma once

#include <mpi.h>

#include <span>

#include "solvers/eigen/search.hpp"

namespace carillon::solvers::eigen {

/// @throws core::InputError  the band is empty
void check_band(const modes::Band& band);

/// Refuses what solve_modes() refuses.
/// @throws core::InputError  see solve_modes
void check_input(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                 const modes::Band& band);

/// Bodies of fewer unknowns are solved by each of a group's ranks alone: splitting them would gain
/// nothing, and parts could be empty.
bool too_small_to_split(const mesh::TetMesh& mesh, MPI_Comm comm);

/// The modes inside a band from what was found: fields, shares and certificate.
/// @param regions  those whose stiffness the pairs belong to
/// @param system   gives scales and partition, whatever its stiffness
/// @param chosen   if not null, is filled with the pair that each mode was made from
/// @note Collective on comm.
modes::Modes select_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                          const modes::Band& band, const assembly::System& system,
                          const SearchResult& found, MPI_Comm comm,
                          std::vector<std::size_t>* chosen = nullptr);

}  // namespace carillon::solvers::eigen
