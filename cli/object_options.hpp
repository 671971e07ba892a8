#pragma once

#include <optional>
#include <string>

#include "cli/context.hpp"
#include "scene/object.hpp"

namespace carillon::cli {

class Command;

/// An object and how to solve it, as typed.
struct ObjectOptions {
  std::string mesh;       ///< file, or FAMILY[:parameter=value,...]
  std::string material;   ///< preset or key=value list; for MSH groups: group=name,...
  std::string length;     ///< longest side with unit; "": as it is
  std::string thickness;  ///< of open sheets
  std::string unit, first_axis, second_axis;
  std::string node;                      ///< of a file with several; "": all as one body
  std::string profile_axis, profile_id;  ///< of an SVG drawing
  bool any_size = false;
  std::optional<int> order;  ///< of tetrahedra; 3 when none is given
  std::string element_size;
  std::string min_frequency = "20 Hz";
  std::optional<std::string> max_frequency;  ///< 20 kHz when none is given
  int max_modes = 300;
  // Given or not: what does not apply to an object is refused, not ignored.
  std::optional<std::string> mirror_planes;  ///< automatic when none is given
  std::optional<std::string> linear_solver;  ///< automatic when none is given
  std::optional<std::string> memory_limit;   ///< 16 GiB when none is given
  std::optional<int> max_elements;           ///< 200,000 when none is given
  /// automatic when none is given, or tetrahedra where an option of theirs is.
  std::optional<std::string> solver;
  std::optional<std::string> eigen_solver;  ///< block_lanczos when none is given
  /// 5 when none is given, or off where order or element_size are.
  std::optional<std::string> pitch_cents;
  std::optional<int> max_unknowns;  ///< of refinements; 120,000 when none is given
  std::optional<int> edge_layers;   ///< at inward edges; 1 when none is given
  std::string tune;                 ///< pitch that the object is scaled to; "": its size is given
  std::optional<int> tune_mode;     ///< that is at it; 1 when none is given
};

/// Adds the options of an object to a command.
void add_object_options(Command& command, ObjectOptions& options);

/// Adds the options that scale an object to a pitch, which solve_object() heeds.
void add_tuning_options(Command& command, ObjectOptions& options);

/// The object that the options name, of no material where none is given.
/// @throws InputError  as scene::parse_object, a malformed length, or an option that would do
///                     nothing for this object
scene::Object named_object(const ObjectOptions& options);

/// Its object, and how it is to be meshed.
/// @throws InputError  as named_object
solvers::mesh::MeshRequest mesh_request(const ObjectOptions& options);

/// Whether the object is a glTF file with a modal model and no material is given: it sounds as the
/// file says, and nothing is solved.
bool comes_with_modes(const ObjectOptions& options);

/// Where no material is given, takes the usual one of the object's family, and says so.
/// @throws InputError  as named_object, or there is none
void name_material(ObjectOptions& options, const Context& context);

/// What it is made of; empty where no material is given.
/// @throws InputError  as named_object, an unknown material
scene::RegionMaterials region_materials(const ObjectOptions& options);

/// What the options ask for.
/// @throws InputError  as named_object, a malformed value, an empty band, or an option that the
///                     solver has no use for
scene::ObjectRequest object_request(const ObjectOptions& options);

/// scene::solve_object() or, of a pitch to tune to, scene::solve_tuned() of what the options ask
/// for.
/// @param struck  [m], refused where it is off the object
/// @throws InputError  both a pitch and a size; and as these
/// @note Collective on the context's world.
scene::SolvedObject solve_object(const ObjectOptions& options, const Context& context,
                                 const std::optional<Vec3>& struck = {});

}  // namespace carillon::cli
