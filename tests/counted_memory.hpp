#pragma once

#include <cstddef>

namespace carillon::test {

/// What a program that links counted_memory.cpp has asked operator new for so far; what was given
/// back is not taken off.
struct Allocated {
  std::size_t times = 0;
  std::size_t bytes = 0;
};
Allocated allocated();

}  // namespace carillon::test
