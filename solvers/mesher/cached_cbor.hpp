#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "core/cached.hpp"
#include "core/files.hpp"

namespace carillon::solvers::mesher {

/// core::cached for what goes to JSON and back, kept as CBOR.
template <class T>
T cached_cbor(const std::filesystem::path& folder, const std::string& name,
              const std::function<T(const nlohmann::json&)>& from_json,
              const std::function<T()>& make) {
  return core::cached<T>(
      folder, name,
      [&from_json](const std::filesystem::path& path) {
        return from_json(nlohmann::json::from_cbor(core::read_file(path)));
      },
      [](const std::filesystem::path& path, const T& made) {
        const auto bytes = nlohmann::json::to_cbor(to_json(made));
        core::write_text_durably(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
      },
      make);
}

}  // namespace carillon::solvers::mesher
