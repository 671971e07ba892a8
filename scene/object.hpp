#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "scene/solved_object.hpp"

namespace carillon::scene {

/// Folders CLASS/train/*.off and CLASS/test/*.off, as those of ModelNet (Wu et al. 2015).
struct ModelNet {
  std::vector<std::string> classes;  ///< of these alone; empty: of all
  int per_class = 0;                 ///< at most so many of train and test together; 0: all
};

/// Which nodes of a scene's file are objects.
struct NodeChoice {
  bool each = false;               ///< each is an object of its own; false: the file is one
  std::vector<std::string> names;  ///< these alone are objects; empty: as `each` says
};

/// How a file's profile is read.
struct ProfileOptions {
  /// Of an SVG drawing: left, right or x=NUMBER; "": x=0, which the outline has to reach.
  std::string axis;
  std::string outline;  ///< the id of its outline; "": the only one
  double height = 0;    ///< [m]; 0: as the file says
};

/// What is struck: a family of generated objects or files that match a pattern, and what they are
/// made of.
struct Object {
  std::string name;    ///< the family's by default; of files "" unless one is given
  std::string family;  ///< "" for files
  std::map<std::string, core::Range> parameters;  ///< [m], every parameter of the family
  std::vector<std::array<double, 2>> profile;     ///< of the family "turned" [m]
  std::string profile_file;                       ///< path of the profile's SVG or CSV; "" for none
  std::string pattern;                            ///< path of a mesh file, or a glob of several
  std::string manifest;                           ///< path of a table of files instead; "" for none
  std::string manifest_folder;                    ///< that its files are meant from
  bool named_by_folder = false;  ///< objects are named after their path below the pattern's folder
  NodeChoice nodes;
  std::optional<ModelNet> modelnet;  ///< they lie in its folders
  /// Options of those files; length and any_size count for families too.
  solvers::mesh::MeshFile file;
  /// Where the materials' own axes lie in the object, as columns of a rotation.
  Eigen::Matrix3d material_axes = Eigen::Matrix3d::Identity();
  ObjectSolver solver = ObjectSolver::automatic;
  std::vector<std::string> materials;         ///< names, each a variant of its objects
  std::map<std::string, std::string> groups;  ///< instead: physical group -> material
};

/// Reads an entry of `objects:`; of a `manifest:` what holds for all of its rows. Keys that only
/// some readers know (`count`, `sizes`, `levels`) are theirs to read from the same node.
/// @param shared_materials  of objects that name none; where there are none either, objects are of
///                          their family's usual material, if it has one, and rows of a manifest of
///                          those that it names
/// @param own        materials beside the presets
/// @param file_name  paths in the configuration are relative to its folder
/// @throws ConfigError
Object read_object(core::ConfigNode& node, const std::vector<std::string>& shared_materials,
                   const std::vector<synth::material::Material>& own, const std::string& file_name);

/// Reads its family, parameters and profile alone, where there is nothing else to say.
/// @throws ConfigError
Object read_shape(core::ConfigNode& node, const std::string& file_name);

/// The object that a command line names.
/// @param shape     a file (SVG and CSV: a profile that is turned), or a family with some of its
///                  parameters: `bowl:radius=60mm,wall=3mm`
/// @param material  `steel`, `youngs_modulus=7.2e10,...`, by physical group
///                  `shell=steel,core=wood`, or "" for none
/// @throws InputError  unknown family or parameter, malformed value
/// @throws FileError   no such file
Object parse_object(const std::string& shape, const std::string& material,
                    const ProfileOptions& profile = {});

/// The material of objects that name none: their family's usual one, "" where it has none.
std::string usual_material(const Object& object);

/// Its one object: the file, or the shape with each parameter in the middle of its range.
/// @throws InputError  the parameters contradict each other
solvers::mesh::MeshRequest mesh_request(const Object& object);

/// Axes of a material in an object, as columns of a rotation.
/// @param first   along its first axis; none: x
/// @param second  in the plane of the first two; none: y, or z where the first one is y
/// @throws InputError  they have no length or lie along each other
Eigen::Matrix3d material_axes(const std::optional<Vec3>& first, const std::optional<Vec3>& second);

/// A material by its name, turned as it lies in an object.
/// @throws InputError  an unknown material
synth::material::Material object_material(const Object& object, const std::string& name,
                                          const std::vector<synth::material::Material>& own);

/// What fills the regions of its objects' meshes, turned as it lies in them.
/// @param material  one of the object's; not looked at where physical groups have theirs
/// @throws InputError  an unknown material
RegionMaterials region_materials(const Object& object, const std::string& material,
                                 const std::vector<synth::material::Material>& own = {});

}  // namespace carillon::scene
