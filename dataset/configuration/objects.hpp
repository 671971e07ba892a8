#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "scene/object.hpp"

namespace carillon::dataset::configuration {

/// A factor on every length that is normally distributed among the instances of an object.
struct DrawnSize {
  double mean = 1;
  double deviation = 0;  ///< a thousandth to a quarter of the mean; draws lie within three of them
};

/// What a row of a manifest says of its file beside what scene::Object holds.
struct ManifestRow {
  std::string place;   ///< "objects.csv:12"
  std::string name;    ///< of its object; "": after the file
  std::string family;  ///< label; "": the entry's name
  std::string part;    ///< train, validation or test; "": by the hash of its shape
  std::map<std::string, std::string> labels;  ///< by the names of all further columns
};

/// One entry of `objects:`, or one row of a manifest, with the objects and variants that a build
/// makes of it.
struct ObjectSource {
  scene::Object object;
  std::size_t entry = 0;  ///< its place in `objects:`; the rows of a manifest have one in common
  std::optional<ManifestRow> row;       ///< of a manifest
  int count = 1;                        ///< instances of a family: name-000, name-001, ...
  std::vector<double> sizes;            ///< factors on every length
  std::optional<DrawnSize> drawn_size;  ///< one more, each instance its own
  std::vector<double> tune;             ///< instead: pitches, each brought about by a size [Hz]
  int tune_mode = 1;                    ///< mode that is at them, counted from the lowest
};

enum class Which { all, first, last };

/// Which of its materials and of its sizes every object sounds in. Its modes serve all of them, so
/// builds that differ in this alone share every solve.
struct VariantChoice {
  Which materials = Which::all;
  Which sizes = Which::all;
  int materials_per_group = 0;  ///< so many of each group are drawn for a shape; 0: all are taken
};

/// Factors on the constants of materials, which every shape draws anew for each of its materials,
/// uniformly in the logarithm.
struct MaterialSpread {
  core::Range youngs_modulus = {1, 1};
  core::Range density = {1, 1};
  core::Range damping = {1, 1};  ///< of the coefficient c at every frequency

  bool operator==(const MaterialSpread&) const = default;
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
std::vector<std::string> object_files(const scene::Object& object);

/// Equal for entries that have the same files.
std::string files_key(const scene::Object& object);

/// scene::read_object() with `count`, `sizes`, `drawn_size` and `tune`; the rows of a `manifest:`
/// each.
/// @throws ConfigError  of a manifest with every row that is wrong, each with its line
std::vector<ObjectSource> read_objects(core::ConfigNode& node,
                                       const std::vector<std::string>& shared_materials,
                                       const std::vector<synth::material::Material>& own,
                                       const std::string& file_name);

/// `variants:` of a configuration.
/// @throws ConfigError
VariantChoice read_variant_choice(core::ConfigNode node);

/// `material_spread:` of a configuration.
/// @throws ConfigError
MaterialSpread read_material_spread(core::ConfigNode node);

}  // namespace carillon::dataset::configuration
