#pragma once

#include <string>
#include <utility>
#include <vector>

#include "dataset/exporters/data_card.hpp"

namespace carillon::dataset::exporters {

/// Parts with their rows: train, validation and test first, then others by name.
std::vector<std::pair<std::string, std::vector<std::size_t>>> parts_in_order(
    const ExportedRows& rows);

/// The YAML header of a card, with the lines `---` around it. That of a `lhotse` export names
/// neither files nor types: the Hub has no loader for its manifests.
std::string card_header(const CardSource& source, const ExportedRows& rows,
                        const core::Hdf5Group& index);

}  // namespace carillon::dataset::exporters
