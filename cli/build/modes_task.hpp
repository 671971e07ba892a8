#pragma once

#include <mpi.h>

#include <filesystem>
#include <vector>

#include "cli/build/plan.hpp"
#include "core/trace.hpp"
#include "solvers/solve_materials.hpp"

namespace carillon::cli {

/// Where a build reads and writes.
struct BuildFolders {
  std::filesystem::path output;
  std::filesystem::path cache;  ///< "" for none
  std::filesystem::path modes_file(const Shape& shape) const;
  std::filesystem::path shard_file(const BuildTask& task) const;
};

/// Which solved mode set a variant uses, and the exact rescaling from it.
struct VariantModes {
  std::size_t set = 0;
  double length = 1, modulus = 1, density = 1;  ///< factors for solvers::rescale
};

/// Variants that one mode set serves: equal Poisson's ratios, and equal ratios of moduli and
/// densities between regions.
struct ModeSets {
  /// Each set's regions, those of its slowest variant, and a band wide enough for every variant.
  std::vector<solvers::ModeRequest> requests;
  std::vector<VariantModes> variants;
};
ModeSets group_variants(const std::vector<std::vector<synth::Material>>& materials,
                        const std::vector<Variant>& variants, const solvers::Band& band);

/// Meshes a shape, solves its mode sets and writes them with its voxels and picture to its modes
/// file. Returns paths of the files written, relative to the output folder.
/// @note Collective on comm.
std::vector<std::string> run_modes_task(const BuildConfig& config, const Shape& shape,
                                        const BuildFolders& folders, MPI_Comm comm,
                                        core::Trace& trace);

}  // namespace carillon::cli
