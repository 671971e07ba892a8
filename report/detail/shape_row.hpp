#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "dataset/samples/shape_modes.hpp"
#include "dataset/stored/stored_dataset.hpp"

namespace carillon::report {

/// A mode by how far it may be from the object's own.
struct ModeError {
  double cents = 0, hertz = 0;
  const dataset::plan::Shape* shape = nullptr;
  const dataset::plan::Variant* variant = nullptr;  ///< the first that has it
  double size = 1;                                  ///< the variant's, tuned or planned
  std::size_t set = 0, in_set = 0;                  ///< of the modes file
  std::size_t number = 1;                           ///< in the variant
};
nlohmann::ordered_json to_json(const ModeError& mode);

/// Those with the largest errors, the largest first.
/// @param all  in any order; cut to `count`
void keep_worst(std::vector<ModeError>& all, std::size_t count);

/// An object's row of the report, from its modes file where there is one.
/// @param seconds  of its modes, or null
/// @param errors   its modes with an estimate are added
nlohmann::ordered_json shape_row(const dataset::stored::StoredDataset& dataset,
                                 const dataset::plan::Shape& shape, const nlohmann::json& seconds,
                                 std::vector<ModeError>& errors);

}  // namespace carillon::report
