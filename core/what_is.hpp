#pragma once

#include <filesystem>
#include <string>

namespace carillon::core {

/// What a person may have meant by a path, told by the files that a folder holds and by the first
/// bytes of a file; for messages about the wrong one.
struct WhatIs {
  std::string name;    ///< "a dataset", "a WAV file", "missing", ...; of nothing known "a folder"
  std::string takes;   ///< which commands take it, as a hint; "": none is known
  bool sound = false;  ///< a kind of file that holds one
};
WhatIs what_is(const std::filesystem::path& path);

}  // namespace carillon::core
