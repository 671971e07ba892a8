#pragma once

#include <filesystem>
#include <string>

namespace carillon::eval::studies {

/// Lets a script draw the pictures of a JSON document beside it. The script is looked for beside
/// the program, in its share folder and in the source tree; Python is $CARILLON_PYTHON, else the
/// first of the path and the system's that has matplotlib.
/// @param script  name of a file of scripts/
/// @return "" or why there is no picture, for a person
std::string draw_picture(const std::string& script, const std::filesystem::path& document);

}  // namespace carillon::eval::studies
