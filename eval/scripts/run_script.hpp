#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace carillon::eval::scripts {

/// Runs a script of scripts/ that needs a module of Python, and exits with 4 where it is not there.
/// The script is looked for beside the program, in its share folder and in the source tree; Python
/// is $CARILLON_PYTHON, else the first of the path and the system's that has the module.
/// @param module  for messages
/// @return "" or why it did not run to its end, for a person
std::string run_script(const std::string& name, const std::vector<std::string>& arguments,
                       const std::string& module);

/// Lets a script draw the pictures of a JSON document beside it.
/// @return "" or why there is no picture, for a person
std::string draw_picture(const std::string& script, const std::filesystem::path& document);

}  // namespace carillon::eval::scripts
