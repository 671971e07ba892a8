#pragma once

#include <string>
#include <vector>

#include "core/columns.hpp"
#include "synth/material/material.hpp"

namespace carillon::dataset::samples {

/// Units of the columns alpha1, alpha2, ... of a build: as many as its most demanding model has
/// parameters, at least two. Where models give an alpha different units, "SI" (its damping_model
/// then says which).
std::vector<std::string> damping_column_units(
    const std::vector<synth::material::Material>& materials);

/// Adds damping_model and alpha1, alpha2, ...; NaN where the model has no such parameter.
void add_damping_columns(const synth::damping::DampingModel& model,
                         const std::vector<std::string>& units, core::Columns& columns);

}  // namespace carillon::dataset::samples
