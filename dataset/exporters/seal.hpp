#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>

namespace carillon::dataset::exporters {

/// What an export that hides labels keeps from those who get it: the key by which the hidden
/// samples' names were made. Samples' own keys name their object and material, and their ids follow
/// from these; whoever has the configuration could make them all.
struct Seal {
  std::string secret;           ///< core::make_secret()
  std::string split;            ///< column that says which samples are hidden
  std::set<std::string> parts;  ///< of it, those that are
  std::string dataset;          ///< hash of the dataset's keys

  /// Name of a hidden sample: 32 hexadecimal digits of core::hmac_sha256() of its key.
  std::string id_of(const std::string& key) const;
  bool is_of(std::span<const std::string> keys) const;
};

/// A new one, of the system's random numbers.
/// @param keys  of all samples of the dataset
Seal make_seal(const std::string& split, const std::set<std::string>& parts,
               std::span<const std::string> keys);

nlohmann::ordered_json to_json(const Seal& seal);
/// @throws InputError  it is none
Seal seal_from(const nlohmann::json& document);

/// Readable by the owner alone.
/// @throws StorageError
void write_seal(const std::filesystem::path& path, const Seal& seal);

/// @throws FileError  it is not there, or no seal
Seal read_seal(const std::filesystem::path& path);

}  // namespace carillon::dataset::exporters
