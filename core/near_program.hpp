#pragma once

#include <filesystem>
#include <initializer_list>
#include <string_view>

namespace carillon::core {

/// A file that belongs to this program, whether it runs from where it was built or is installed.
///
/// @param places  paths from the folder of this program
/// @return the first that exists; empty where none does
std::filesystem::path find_near_program(std::initializer_list<std::string_view> places);

/// A program that this one starts: installed, in ../libexec/carillon; beside this one, as built;
/// one folder up, as tests lie in a folder of their own; for a module that another program has
/// loaded, in libexec/carillon of a folder above the module, or as built; or, for programs of
/// others that use the library, in ../libexec/carillon of the `carillon` in PATH.
/// @return empty where there is none
std::filesystem::path find_helper(std::string_view name);

/// The program `carillon`, for a module that starts it: in a folder above the module, as built, or
/// in bin of one, as installed; else in PATH.
/// @return empty where there is none
std::filesystem::path find_carillon();

}  // namespace carillon::core
