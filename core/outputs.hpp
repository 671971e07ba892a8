#pragma once

#include <filesystem>

namespace carillon::core {

/// Refuses an output file that write_durably could not write, before there is anything to write.
/// Leaves nothing behind, makes no folder, and what stands there already is not touched.
/// @throws FileError  names the path, what stands in the way and the system's reason
void require_writable_file(const std::filesystem::path& path);

/// The same for a folder of results, which may be there already.
/// @throws FileError
void require_writable_folder(const std::filesystem::path& path);

}  // namespace carillon::core
