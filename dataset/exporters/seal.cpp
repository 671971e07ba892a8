#include "dataset/exporters/seal.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/json.hpp"

namespace carillon::dataset::exporters {

namespace {

namespace fs = std::filesystem;

std::string keys_hash(std::span<const std::string> keys) {
  core::Sha256 hash;
  for (const std::string& key : keys) hash.add(key).add("\n");
  return hash.hex();
}

}  // namespace

std::string Seal::id_of(const std::string& key) const {
  return core::hmac_sha256(secret, key).substr(0, 32);
}

bool Seal::is_of(std::span<const std::string> keys) const {
  return keys_hash(keys) == dataset;
}

Seal make_seal(const std::string& split, const std::set<std::string>& parts,
               std::span<const std::string> keys) {
  return {core::make_secret(), split, parts, keys_hash(keys)};
}

nlohmann::ordered_json to_json(const Seal& seal) {
  return {{"carillon_seal", 1},
          {"secret", seal.secret},
          {"split", seal.split},
          {"parts", seal.parts},
          {"dataset", seal.dataset}};
}

Seal seal_from(const nlohmann::json& document) {
  try {
    if (document.at("carillon_seal") == 1) {
      return {document.at("secret"), document.at("split"), document.at("parts"),
              document.at("dataset")};
    }
  } catch (const nlohmann::json::exception&) {
    // Said below.
  }
  throw core::InputError("that is no seal of an export",
                         "carillon export --hide test writes it, beside the export");
}

void write_seal(const fs::path& path, const Seal& seal) {
  core::write_durably(path, [&](const fs::path& temporary) {
    core::write_text_durably(temporary, to_json(seal).dump(1) + "\n");
    fs::permissions(temporary, fs::perms::owner_read | fs::perms::owner_write);
  });
}

Seal read_seal(const fs::path& path) {
  if (!fs::is_regular_file(path)) {
    throw core::FileError(fmt::format("{}: no such file", path.string()));
  }
  try {
    return seal_from(core::read_json(path));
  } catch (const core::InputError& error) {
    throw core::FileError(fmt::format("{}: {}", path.string(), error.message()), error.hint());
  }
}

}  // namespace carillon::dataset::exporters
