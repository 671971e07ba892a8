#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/looks/appearance.hpp"
#include "solvers/elements/elastic.hpp"
#include "synth/damping/damping.hpp"

namespace carillon::synth::material {

struct Material {
  std::string name;
  solvers::elements::Elastic elastic;
  damping::DampingModel damping;
  std::string source;      ///< paper and table, handbook for what the table lacks
  std::string group = {};  ///< one of material_groups(); "": not said
  std::optional<render::looks::Appearance> appearance = {};  ///< its own; nothing: by its name
};

/// Kinds of materials, which tell how an object looks: metal, wood, stone, ceramic, glass, plastic,
/// rubber, other.
const std::vector<std::string>& material_groups();

/// What it looks like: its own appearance, else by its name and group.
render::looks::Appearance appearance_of(const Material& material);

/// Presets: the rows of share/carillon/materials.yaml, which is within the library; read when they
/// are first asked for. First those of the papers, every row of their damping parameters:
///
/// - ceramic, glass, wood, plastic, iron, polycarbonate, steel: Hiner 2024, Table 1 (Rayleigh).
/// - sterling_porcelain, _travertine, _wood, _steel, _plastic, _glass: Sterling 2019, Table 4.1,
/// the
///   Rayleigh rows; with `_hybrid` behind the name the hybrid rows.
/// - gpd_plastic_1, gpd_plastic_2, gpd_porcelain, gpd_wood, gpd_aluminum: Sterling 2019, Table 3.1,
///   the Rayleigh rows; with `_caughey` and `_power` behind the name those rows.
///
/// - spruce, maple, oak: orthotropic woods of the Wood Handbook, damped as Hiner's wood.
///
/// Then metals, woods, stones, ceramics, glasses, plastics, laminates, rubbers and others from
/// handbooks. `source` says where each value is printed and what is an assumption.
const std::vector<Material>& preset_materials();

/// A preset by name, or
/// `youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700[,alpha1=6,alpha2=1e-7]` (units allowed:
/// `72 GPa`; damping left out is no damping). Anisotropic solids: `E1=...,E2=...,E3=...,nu12=...,
/// nu13=...,nu23=...,G12=...,G13=...,G23=...` (nu_ij: strain along j under a stress along i), cubic
/// `C11,C12,C44`, hexagonal `C11,C12,C13,C33,C44`, or `stiffness=` with the 36 entries or the 21 of
/// the upper triangle (Voigt's order 11 22 33 23 13 12) between blanks. Other damping:
/// `damping=hybrid,alpha1=3.9,...` or a formula, `damping=6 + 1e-7*lambda`; commas within
/// parentheses belong to the formula.
/// @throws InputError  unknown (names the nearest), malformed or unphysical
Material parse_material(const std::string& text);
/// The same, where a configuration's or file's own materials come first.
Material parse_material(const std::string& text, const std::vector<Material>& own);
/// @throws InputError  modulus or density not positive, nu outside (-1, 0.5), or damping that
///                     check_damping() refuses
void check_material(const Material& material);

/// Materials of a YAML file: name -> the same fields, and `group` and `citation` if wanted.
/// `damping` is a model's name or a formula, with alpha1, alpha2, ... beside it; or a mapping
/// `{model: hybrid, alpha1: ..., ...}`.
/// @throws ConfigError  unknown key, wrong unit, unphysical value, or a name that keys of samples
///                      cannot have, with file:line:column
/// @throws FileError    not readable
std::vector<Material> read_materials(const std::string& path);

}  // namespace carillon::synth::material
