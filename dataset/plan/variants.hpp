#pragma once

#include <string>
#include <vector>

#include "dataset/configuration/configuration.hpp"
#include "scene/solved_object.hpp"

namespace carillon::dataset::plan {

struct Shape;

/// A shape made of a material at a size.
struct Variant {
  std::string material;  ///< name, or group=name,... for an object of several
  double size = 1;       ///< factor on every length; of a tuned one as far as it is known
  bool sounds = true;    ///< samples are made of it; the modes serve the others, too
  double tune = 0;       ///< pitch that its size gives it [Hz]; 0: its size is given
  int tune_mode = 1;     ///< mode that is at the pitch, counted from the lowest
};

/// What tells a variant from others of its material: its size, or its pitch as 440Hz and, where the
/// mode is not the lowest, 440Hz-mode-2. Part of keys.
std::string size_name(const Variant& variant);
/// Shape, material and size of an object, as keys of its samples begin: "bowl-003/glass/1".
std::string object_name(const std::string& shape, const Variant& variant);

/// Every material and size of a shape, drawn ones among them.
/// @param id  of the shape
/// @throws InputError  an unknown material
std::vector<Variant> make_variants(const configuration::BuildConfig& config,
                                   const configuration::ObjectSource& source,
                                   const std::string& id);

/// Materials of a variant, by region, with the constants that its shape has drawn.
/// @throws InputError  an unknown material
scene::RegionMaterials region_materials(const configuration::BuildConfig& config,
                                        const Shape& shape, const Variant& variant);

/// The same, one per region of the mesh.
/// @throws InputError  the mesh's groups and the configuration's do not match
std::vector<synth::material::Material> variant_materials(const configuration::BuildConfig& config,
                                                         const Shape& shape, const Variant& variant,
                                                         const std::vector<std::string>& regions);

}  // namespace carillon::dataset::plan
