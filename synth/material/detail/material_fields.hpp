#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/fault.hpp"
#include "core/units.hpp"
#include "solvers/elements/anisotropy.hpp"
#include "synth/material/material.hpp"

namespace carillon::synth::material {

/// An elastic constant that a material may be stated by: what it is called and measures.
struct ElasticField {
  const char* name;
  core::Dimension dimension;
};

/// A set of constants that states a solid.
struct ElasticLaw {
  const char* name;
  std::vector<ElasticField> fields;
  solvers::elements::Voigt (*stiffness)(const std::vector<double>&);  ///< null: isotropic
};
/// Isotropic, orthotropic (nine engineering constants), cubic and hexagonal solids. Every way to
/// state a material walks this list; a whole matrix (`stiffness`) stands beside it.
const std::vector<ElasticLaw>& elastic_laws();
/// All of their fields and the density, each once.
std::vector<ElasticField> elastic_fields();

/// Constants as they were given, by their names, or a stiffness [Pa].
struct GivenElastic {
  std::map<std::string, double> constants;
  std::optional<solvers::elements::Voigt> stiffness = {};
};

/// The solid of given constants; a fault where they state none, not a fault where they are unsound.
std::optional<core::Fault> make_elastic(const GivenElastic& given,
                                        solvers::elements::Elastic& elastic);

/// A stiffness from 36 entries row by row, or the 21 of its upper triangle; nothing where there are
/// others or it is not symmetric.
std::optional<solvers::elements::Voigt> stiffness_matrix(const std::vector<double>& entries);

/// The first rule a material breaks; its key is a field or that of the damping.
std::optional<core::Fault> material_fault(const Material& material);

/// A material from `key=value,key=value`; not checked.
/// @throws InputError  malformed, unknown key, or one that is missing
Material parse_fields(const std::string& text);

}  // namespace carillon::synth::material
