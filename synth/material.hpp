#pragma once

#include <string>
#include <vector>

#include "solvers/modes.hpp"

namespace carillon::synth {

/// Rayleigh damping: c(lambda) = alpha1 + alpha2 lambda [1/s], decay rate d = c / 2.
struct RayleighDamping {
  double alpha1 = 0;  ///< mass-proportional [1/s]
  double alpha2 = 0;  ///< stiffness-proportional [s]
};

struct Material {
  std::string name;
  solvers::Elastic elastic;
  RayleighDamping damping;
  std::string source;  ///< paper and table, handbook for what the table lacks
};

/// Presets: the seven of Hiner 2024, Table 1 (ceramic, glass, wood, plastic, iron, polycarbonate,
/// steel) and the six of Sterling 2019, Table 4.1, Rayleigh rows, all with the prefix `sterling_`
/// (porcelain, travertine, wood, steel, plastic, glass). That table lacks E, nu and rho: they come
/// from handbooks, and `source` says which.
const std::vector<Material>& preset_materials();

/// A preset by name, or
/// `youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700[,alpha1=6,alpha2=1e-7]` (units allowed:
/// `72 GPa`; damping left out is no damping).
/// @throws InputError  unknown (names the nearest), malformed or unphysical
Material parse_material(const std::string& text);
/// The same, where a configuration's or file's own materials come first.
Material parse_material(const std::string& text, const std::vector<Material>& own);
/// @throws InputError  modulus or density not positive, nu outside (-1, 0.5), negative damping
void check_material(const Material& material);

/// Materials of a YAML file: name -> the same fields, and `source` as a text if wanted.
/// @throws ConfigError  unknown key, wrong unit or unphysical value, with file:line:column
/// @throws FileError    not readable
std::vector<Material> read_materials(const std::string& path);

}  // namespace carillon::synth
