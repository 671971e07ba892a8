#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/units.hpp"
#include "synth/material/material.hpp"

namespace carillon::synth::material {

/// An elastic constant of a material: what it is called, measures, and where it is kept. Every way
/// to state a material walks this list.
struct ElasticField {
  const char* name;
  core::Dimension dimension;
  double& (*value)(Material&);
};
inline constexpr std::array<ElasticField, 3> elastic_fields = {{
    {"youngs_modulus", core::Dimension::pressure,
     [](Material& m) -> double& { return m.elastic.youngs_modulus; }},
    {"poisson_ratio", core::Dimension::none,
     [](Material& m) -> double& { return m.elastic.poisson_ratio; }},
    {"density", core::Dimension::density, [](Material& m) -> double& { return m.elastic.density; }},
}};

/// The first rule a material breaks; its key is a field or that of the damping.
std::optional<core::Fault> material_fault(const Material& material);

/// A material from `key=value,key=value`; not checked.
/// @throws InputError  malformed, unknown key, or one that is missing
Material parse_fields(const std::string& text);

/// "; did you mean "x"?", or nothing.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& names);

}  // namespace carillon::synth::material
