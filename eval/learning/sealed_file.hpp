#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace carillon::eval::learning {

/// A file of a header and blocks of bytes that knows whether it is whole: one line of JSON with the
/// SHA-256 of what follows it, then the blocks.
struct SealedFile {
  nlohmann::json header;
  std::vector<std::string> blocks;
};

/// @throws StorageError
void write_sealed(const std::filesystem::path& path, const SealedFile& file);

/// @throws FileError   not readable
///         InputError  cut short, or changed
SealedFile read_sealed(const std::filesystem::path& path);

}  // namespace carillon::eval::learning
