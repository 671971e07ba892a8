#pragma once

#include <exception>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace carillon::core {

/// Says that a cached file is of no use, and why.
void tell_unusable(const std::filesystem::path& file, const std::exception& error);

/// What `read` makes of a file; nothing where there is none, or where `read` throws.
template <class T>
std::optional<T> from_cache(const std::filesystem::path& file,
                            const std::function<T(const std::filesystem::path&)>& read) {
  std::error_code missing;
  if (!std::filesystem::exists(file, missing)) return std::nullopt;
  try {
    return read(file);
  } catch (const std::exception& error) {
    tell_unusable(file, error);
    return std::nullopt;
  }
}

/// Writes a file of a cache so that others see it whole or not at all. Where it cannot be written
/// the result is as good, and only the next run is slower: that is told once for each folder.
void to_cache(const std::filesystem::path& file,
              const std::function<void(const std::filesystem::path&)>& write);

/// A result that can be computed again, kept in a folder.
/// @param folder  empty: nothing is kept
/// @param name    of the file: the hash of all that the result depends on, and an ending
/// @param read    of such a file; throws where it is damaged
/// @param write   the result to a file
/// @param make    computes it
template <class T>
T cached(const std::filesystem::path& folder, const std::string& name,
         const std::function<T(const std::filesystem::path&)>& read,
         const std::function<void(const std::filesystem::path&, const T&)>& write,
         const std::function<T()>& make) {
  if (folder.empty()) return make();
  const std::filesystem::path file = folder / name;
  if (std::optional<T> kept = from_cache<T>(file, read)) return *std::move(kept);
  T made = make();
  to_cache(file, [&](const std::filesystem::path& path) { write(path, made); });
  return made;
}

}  // namespace carillon::core
