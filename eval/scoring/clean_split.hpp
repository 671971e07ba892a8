#pragma once

#include <filesystem>
#include <string>

namespace carillon::eval::scoring {

/// Holds a dataset's splits against what is stored: no object in two parts, no strike, no room, no
/// stretch of noise (`carillon check`).
/// @param split  column that is learnt by
/// @param cache  folder that remembers which datasets were found clean, while no file of theirs
///               changes: the surfaces of thousands of objects take minutes; "": none
/// @throws InputError  a leak; says which
void require_clean_split(const std::filesystem::path& folder, const std::string& split,
                         const std::filesystem::path& cache);

}  // namespace carillon::eval::scoring
