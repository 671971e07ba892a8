#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "solvers/mesh/shape_source.hpp"
#include "synth/material/material.hpp"

namespace carillon::dataset::configuration {

/// A factor on every length that is normally distributed among the instances of an object.
struct DrawnSize {
  double mean = 1;
  double deviation = 0;  ///< a thousandth to a quarter of the mean; draws lie within three of them
};

/// Folders CLASS/train/*.off and CLASS/test/*.off, as those of ModelNet (Wu et al. 2015).
struct ModelNet {
  std::vector<std::string> classes;  ///< of these alone; empty: of all
  int per_class = 0;                 ///< at most so many of train and test together; 0: all
};

/// One entry of `objects:`: a family of generated bodies or files that match a pattern.
struct ObjectSource {
  std::string name;    ///< instances are name-000, name-001, ...; files keep their own names
  std::string family;  ///< "" for files
  int count = 1;       ///< instances of a family
  std::map<std::string, core::Range> parameters;  ///< [m], every parameter of the family
  std::vector<std::array<double, 2>> profile;     ///< of the family "turned" [m]
  std::string svg;                                ///< path of the profile's file; "" for none
  std::string pattern;                            ///< glob of mesh files
  std::optional<ModelNet> modelnet;               ///< they lie in its folders
  /// Options of those files; length and any_size count for families too.
  solvers::mesh::MeshFile file;
  std::vector<std::string> materials;         ///< one variant each
  std::map<std::string, std::string> groups;  ///< instead: physical group -> material
  std::vector<double> sizes;                  ///< factors on every length
  std::optional<DrawnSize> drawn_size;        ///< one more, each instance its own
};

enum class Which { all, first, last };

/// Which of its materials and of its sizes every body sounds in. Its modes serve all of them, so
/// builds that differ in this alone share every solve.
struct VariantChoice {
  Which materials = Which::all;
  Which sizes = Which::all;
};

/// Class and part (train or test) of a file of ModelNet's folders.
struct ModelNetPlace {
  std::string family;
  std::string part;
};
ModelNetPlace modelnet_place(const std::string& path);

/// Files of an entry of `objects:`, by name. Of a class of ModelNet's that has more than per_class,
/// those whose names have the least hashes: more of them keep the others.
/// @throws FileError  the system cannot search
std::vector<std::string> object_files(const ObjectSource& source);

/// Equal for entries that have the same files.
std::string files_key(const ObjectSource& source);

/// @param shared_materials  of objects that name none
/// @param own        materials beside the presets
/// @param file_name  paths in the configuration are relative to its folder
/// @throws ConfigError
ObjectSource read_object(core::ConfigNode& node, const std::vector<std::string>& shared_materials,
                         const std::vector<synth::material::Material>& own,
                         const std::string& file_name);

/// `variants:` of a configuration.
/// @throws ConfigError
VariantChoice read_variant_choice(core::ConfigNode node);

}  // namespace carillon::dataset::configuration
