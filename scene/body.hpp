#pragma once

#include <optional>
#include <string>

#include "mpi/context.hpp"
#include "solvers/eigen/solve_modes.hpp"
#include "solvers/mesher/mesh_child.hpp"
#include "solvers/pitch/pitch_target.hpp"
#include "synth/material/material.hpp"

namespace carillon::scene {

/// The body that `modes`, `strike` and others take on the command line, and how to solve it.
struct BodyOptions {
  std::string mesh;       ///< file, or FAMILY[:parameter=value,...]
  std::string material;   ///< preset or key=value list; for MSH groups: group=name,...
  std::string length;     ///< longest side with unit; "": as it is
  std::string thickness;  ///< of open sheets
  bool any_size = false;
  std::optional<int> order;  ///< of tetrahedra; 3 when none is given
  std::string element_size;
  std::string min_frequency = "20 Hz";
  std::optional<std::string> max_frequency;  ///< 20 kHz when none is given
  int max_modes = 300;
  // Given or not: what does not apply to a body is refused, not ignored.
  std::optional<std::string> linear_solver;  ///< automatic when none is given
  std::optional<std::string> memory_limit;   ///< 16 GiB when none is given
  std::optional<int> max_elements;           ///< 200,000 when none is given
  std::string solver = "block_lanczos";      ///< or krylov_schur; fourier: see solve_turned()
  double pitch_cents = 0;  ///< refine until the worst mode is within it; 0: as it comes
};

/// A file's name, or `bowl:radius=60mm,wall=3mm` (parameters not named are the middle of their
/// range) as a request to the mesher.
/// @throws InputError  unknown family or parameter, malformed value, or an option that would do
///                     nothing for this body
solvers::mesh::MeshRequest mesh_request(const BodyOptions& options);

/// @throws InputError  an option was given that the fourier solver has no use for
void refuse_tetrahedral_options(const BodyOptions& options);

/// Band and solver that the options ask for.
/// @throws InputError  malformed frequencies or memory, an empty band
solvers::eigen::SolveOptions solve_options(const BodyOptions& options);

/// One material for each region, from the names given to groups.
/// @param own  materials that come before the presets
/// @throws InputError  a region without material, or a group that the mesh does not have
std::vector<synth::material::Material> assign_materials(
    const std::map<std::string, std::string>& groups, const std::vector<std::string>& regions,
    const std::vector<synth::material::Material>& own);

/// One material for each region of a mesh, from `steel` or from `shell=steel,core=wood`.
/// @throws InputError  a region without material, or a name that is no region
std::vector<synth::material::Material> region_materials(const std::string& text,
                                                        const std::vector<std::string>& regions);

/// The materials that such a text names, whatever the mesh.
std::vector<synth::material::Material> named_materials(const std::string& text);

/// Bodies outside 1 mm to 10 m are mostly slips of a unit.
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

/// Everything that the options ask for.
struct Body {
  solvers::mesh::MeshResult mesh;
  std::vector<synth::material::Material> materials;  ///< one per region
  solvers::modes::Modes modes;
  std::optional<solvers::pitch::PitchReport> pitch_target;  ///< when one was asked for
  core::Trace trace;
};

/// @note Collective on the context's world.
Body solve_body(const BodyOptions& options, const mpi::Context& context);

std::vector<solvers::elements::Elastic> elastic_of(
    const std::vector<synth::material::Material>& materials);
std::vector<synth::damping::DampingModel> damping_of(
    const std::vector<synth::material::Material>& materials);

}  // namespace carillon::scene
