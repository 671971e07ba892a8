#pragma once

#include "core/error.hpp"

namespace carillon::core {

/// Results cannot be written where they belong: the disk is full, the folder must not be written
/// to. No fault of what was computed: the same again may succeed when there is room.
struct StorageError : FileError {
  using FileError::FileError;
};

}  // namespace carillon::core
