#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/config.hpp"
#include "mpi/comm.hpp"
#include "scene/object_solver.hpp"
#include "solvers/eigen/solve_modes.hpp"
#include "solvers/mesher/mesh_child.hpp"
#include "solvers/pitch/pitch_target.hpp"
#include "synth/material/material.hpp"

namespace carillon::scene {

/// Materials by the region of a mesh that they fill; "" for every region.
using RegionMaterials = std::map<std::string, synth::material::Material>;

/// An object of one or more materials, and how its modes are to be found.
struct ObjectRequest {
  solvers::mesh::MeshRequest mesh;
  RegionMaterials materials;
  bool any_size = false;  ///< lets an object outside 1 mm to 10 m pass
  SolverRequest solver;
  solvers::eigen::SolveOptions solve;
  double pitch_cents = 0;  ///< refine until the worst mode is within it; 0: as it comes
  std::int64_t max_unknowns = solvers::pitch::usual_max_unknowns;  ///< of refinements
  solvers::mesher::ChildLimits limits{};                           ///< of meshing
  std::vector<Vec3> struck{};  ///< points [m] refused as by nearest_point(), before a long solve
};

/// Reads the band of `modes:`.
/// @param otherwise  for keys that are not given
/// @throws ConfigError
solvers::modes::Band read_band(core::ConfigNode& modes, const solvers::modes::Band& otherwise);

/// All of them, each region's own.
std::vector<synth::material::Material> listed(const RegionMaterials& materials);

/// One material for each region of a mesh.
/// @throws InputError  a region without material, or a material of a region that the mesh does not
///                     have
std::vector<synth::material::Material> assign_materials(const RegionMaterials& materials,
                                                        const std::vector<std::string>& regions);

/// Objects outside 1 mm to 10 m are mostly slips of a unit.
/// @param longest  longest side [m], sizes included
/// @throws InputError  outside, and `any_size` is off
void check_size(double longest, bool any_size);

/// Mesh (by a child of rank 0, then broadcast) of a request; failures reach every rank.
/// @note Collective on comm.
solvers::mesh::MeshResult shared_mesh(const solvers::mesh::MeshRequest& request,
                                      const solvers::mesher::ChildLimits& limits,
                                      const std::filesystem::path& cache, MPI_Comm comm);

/// The entry of a trace that making this mesh belongs to: "mesh", or "mesh from cache" where it is
/// there already.
core::Trace::Entry& mesh_entry(core::Trace& trace, const solvers::mesh::MeshRequest& request,
                               const std::filesystem::path& cache);

/// An object with its modes.
struct SolvedObject {
  SolverDecision solver;
  solvers::mesh::MeshResult mesh;  ///< of the axisymmetric solver a region's name alone
  std::vector<synth::material::Material> materials;  ///< one per region
  solvers::modes::Modes modes;
  std::optional<solvers::pitch::PitchReport> pitch_target;  ///< when one was asked for
  std::vector<std::string> warnings;                        ///< mesh_warnings() of a file
  core::Trace trace;
  double size = 1;  ///< factor of every length against the request, see solve_tuned()
};

/// Finds the modes of an object by the solver that decide_solver() names: meshes and modes are each
/// behind the cache (empty path: none). A libraries::SolverEnvironment must be alive.
/// @return the same on every rank
/// @throws InputError   see solve_modes(), assign_materials(), check_size(); an axisymmetric solve
///                      of an object that is not turned about an axis
/// @throws FileError, SolverError, StorageError  as mesh_in_child() and solve_modes() do
/// @note Collective on comm.
SolvedObject solve_object(const ObjectRequest& request, MPI_Comm comm = MPI_COMM_WORLD,
                          const std::filesystem::path& cache = {});

/// The same shape in another material and at another size, by rescale(): exact, nothing is solved.
/// @param size  factor of every length
/// @throws InputError  another Poisson's ratio, an anisotropic material, several regions, a size
///                     that is not positive
SolvedObject in_material(const SolvedObject& object, const synth::material::Material& material,
                         double size);

std::vector<solvers::elements::Elastic> elastic_of(
    const std::vector<synth::material::Material>& materials);
std::vector<synth::damping::DampingModel> damping_of(
    const std::vector<synth::material::Material>& materials);

}  // namespace carillon::scene
