#include "core/json.hpp"

#include "core/files.hpp"

namespace carillon::core {

namespace {

template <class Json>
Json read(const std::filesystem::path& path) {
  std::error_code missing;
  if (!std::filesystem::is_regular_file(path, missing)) return nullptr;
  Json document = Json::parse(read_file(path), nullptr, false);
  return document.is_discarded() ? Json(nullptr) : document;
}

}  // namespace

nlohmann::json read_json(const std::filesystem::path& path) {
  return read<nlohmann::json>(path);
}

nlohmann::ordered_json read_ordered_json(const std::filesystem::path& path) {
  return read<nlohmann::ordered_json>(path);
}

}  // namespace carillon::core
