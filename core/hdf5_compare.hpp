#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace carillon::core {

/// Where the contents of an HDF5 file differ from those of another: groups, arrays with their
/// types, extents and values, the sources of virtual ones (which are not resolved), and attributes.
/// How they lie in the file plays no part.
/// @return one line for each object, which names it and what is there instead; empty: none differs
/// @throws FileError  a file cannot be read
std::vector<std::string> compare_hdf5(const std::filesystem::path& file,
                                      const std::filesystem::path& expected);

}  // namespace carillon::core
