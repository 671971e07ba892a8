#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "core/vectors.hpp"

namespace carillon::render::looks {

/// A pattern throughout the volume, which its surface cuts (solid texture: Peachey 1985).
enum class Grain {
  none,
  wood,      ///< growth rings about a pith along the body's longest axis, and fibres along it
  speckled,  ///< light and dark grains, as granite's
  veined,    ///< dark veins, as marble's
  brushed    ///< lines along the body's longest axis that are smoother or rougher, as of brushed
             ///< metal
};
const char* name_of(Grain grain);

/// What a body looks like: the metallic and roughness model of glTF 2.0.
struct Appearance {
  Vec3 color = {0.7, 0.7, 0.72};  ///< linear reflectance
  double roughness = 0.4;         ///< 0 mirror, 1 matt
  double metallic = 0;      ///< 1: a conductor, which mirrors in its colour and scatters nothing
  double transmission = 0;  ///< fraction let through, tinted by the colour, that others scatter
  double coat = 0;          ///< how much of a layer of clear glaze or varnish is on it, 0 to 1
  Grain grain = Grain::none;
  double grain_contrast = 0.5;     ///< 0: none to be seen, 1: strong
  std::uint64_t piece = 0;         ///< which piece of the material: seed of where its grain lies
  std::vector<Vec3> colours = {};  ///< at the mesh's vertices, in place of `color` and the grain;
                                   ///< empty: none
};

/// What faces of a body look like where they are of other materials than the rest.
struct FaceLooks {
  std::vector<Appearance> others;
  /// Of each triangle: 0 looks like the body, i + 1 like the i-th other; empty: all like the body.
  std::vector<std::int32_t> of_faces = {};
};

/// @throws InputError  a number beyond 0 to 1
void check(const Appearance& appearance);

/// Looks of a material: of the longest ending of its name that is known, in whole words
/// (`bell_bronze` looks like bronze), else of its group (synth::material::material_groups()), else
/// a neutral grey. The rows of share/carillon/appearances.yaml, which is within the library.
Appearance appearance_of(const std::string& material, const std::string& group = "");

/// Keys `base_colour`, `roughness`, `metallic`, `transmission`, `coat`, `grain`, `grain_contrast`;
/// those that are not there are as in `fallback`.
/// @throws ConfigError  unknown key, or a number beyond 0 to 1
Appearance read_appearance(core::ConfigNode node, const Appearance& fallback);

/// The keys that read_appearance() takes.
nlohmann::json to_json(const Appearance& appearance);

}  // namespace carillon::render::looks
