#pragma once

#include "core/error.hpp"

namespace carillon::core {

/// The machine does not give what any work needs: room on a disk, a folder that may be written to
/// (for results or for what is only kept meanwhile), another process, a program of this one. No
/// fault of what was computed: the same again may succeed when the machine is mended.
struct StorageError : FileError {
  using FileError::FileError;
};

}  // namespace carillon::core
