#pragma once

#include <string>

#include "dataset/stored/stored_dataset.hpp"
#include "scene/single_strike.hpp"

namespace carillon::dataset::regenerate {

/// One more sound of an object of a dataset, in the dataset's scene: its modes are read, nothing is
/// solved.
/// @param object  shape, material and size as keys of samples begin, or as much of it as tells the
///                object from others: "bowl-003"
/// @throws InputError  there is none such, or several
/// @throws FileError   its modes file is missing or damaged
scene::StruckSound strike_object(const stored::StoredDataset& dataset, const std::string& object,
                                 const scene::SingleStrike& strike);

}  // namespace carillon::dataset::regenerate
