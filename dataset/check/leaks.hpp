#pragma once

#include <vector>

#include "dataset/check/rows.hpp"

namespace carillon::dataset::check {

/// No object in two parts of split_shape: by its name, and by its surface (whatever its name,
/// place, turn and size). Surfaces are those of modes files, and of mesh files as dataset.json has
/// them.
Finding check_split_shape(const DatasetFolder& folder, const std::vector<Row>& rows);

/// No strike in two parts of split_strike: by its number, and by the point of the object.
Finding check_split_strike(const DatasetFolder& folder, const std::vector<Row>& rows);

/// No room, simulated or measured, in two parts of either split. Rooms that the configuration draws
/// nothing of, and a response that it names, are the same in all parts because it says so: a note.
Finding check_rooms(const std::vector<Row>& rows);

/// No moment of a recording in two parts of either split.
Finding check_noise(const std::vector<Row>& rows);

}  // namespace carillon::dataset::check
