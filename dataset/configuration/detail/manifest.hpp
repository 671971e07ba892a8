#pragma once

#include <vector>

#include "dataset/configuration/objects.hpp"

namespace carillon::dataset::configuration {

/// The rows of an entry's manifest: a CSV file whose first line names the columns. `file` is where
/// a mesh lies, from object.manifest_folder; `length` or `unit`, `thickness`, `material`, `node`,
/// `name`, `family` and `split` say what the entry's keys do, for the row alone, where they are not
/// empty. All other columns are labels.
/// @param entry  what holds where a row says nothing
/// @throws FileError   the manifest cannot be read
/// @throws InputError  no column `file`, no rows, or rows that are wrong: each of them, with its
/// line
std::vector<ObjectSource> rows_of_manifest(const ObjectSource& entry,
                                           const std::vector<synth::material::Material>& own);

}  // namespace carillon::dataset::configuration
