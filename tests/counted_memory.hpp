#pragma once

#include <cstddef>

namespace carillon::cli {

/// Bytes that this program has asked operator new for so far; what was given back is not taken off.
std::size_t allocated_bytes();

}  // namespace carillon::cli
