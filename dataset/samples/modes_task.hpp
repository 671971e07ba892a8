#pragma once

#include <mpi.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/trace.hpp"
#include "dataset/plan/plan.hpp"
#include "solvers/basis/solve_materials.hpp"

namespace carillon::dataset::samples {

/// Where a build reads and writes.
struct BuildFolders {
  std::filesystem::path output;
  std::filesystem::path cache;  ///< "" for none
  std::filesystem::path modes_file(const plan::Shape& shape) const;
  std::filesystem::path shard_file(const plan::BuildTask& task) const;
};

/// Which solved mode set a variant uses, and the exact rescaling from it.
struct VariantModes {
  std::size_t set = 0;
  double length = 1, modulus = 1, density = 1;  ///< factors for solvers::modes::rescale
};

/// Frequencies of a variant over those of its set.
double frequency_factor(const VariantModes& variant);

/// Variants that one mode set serves: equal Poisson's ratios, and equal ratios of moduli and
/// densities between regions.
struct ModeSets {
  /// Each set's regions, those of its slowest variant, and a band wide enough for every variant.
  std::vector<solvers::basis::ModeRequest> requests;
  std::vector<VariantModes> variants;
};
/// @note Of variants whose waves are equally slow, but for rounding, the first counts as slowest.
ModeSets group_variants(const std::vector<std::vector<synth::material::Material>>& materials,
                        const std::vector<plan::Variant>& variants,
                        const solvers::modes::Band& band);

struct ModesTaskResult {
  std::vector<std::string> written;  ///< paths of the files, relative to the output folder
  /// {asked_cents, reached_cents, met}, and of tetrahedra {order, element_size_m} of the setting
  /// that was chosen; null without a pitch target.
  nlohmann::json pitch_target;
  /// For a person: what is doubtful about a file's mesh, a pitch target that was missed.
  std::vector<std::string> warnings;
};

/// Meshes a shape where its solver asks for it, solves its mode sets and writes them with its
/// voxels and picture to its modes file.
/// @note Collective on comm.
ModesTaskResult run_modes_task(const configuration::BuildConfig& config, const plan::Shape& shape,
                               const BuildFolders& folders, MPI_Comm comm, core::Trace& trace);

}  // namespace carillon::dataset::samples
