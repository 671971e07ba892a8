#include "core/cached.hpp"

#include <spdlog/spdlog.h>

#include <mutex>
#include <set>

#include "core/files.hpp"

namespace carillon::core {

void tell_unusable(const std::filesystem::path& file, const std::exception& error) {
  spdlog::warn("{} cannot be used and is made again: {}", file.string(), error.what());
}

void to_cache(const std::filesystem::path& file,
              const std::function<void(const std::filesystem::path&)>& write) {
  try {
    write_durably(file, write);
  } catch (const std::exception& error) {
    static std::mutex mutex;
    static std::set<std::filesystem::path> told;
    const std::lock_guard lock(mutex);
    if (!told.insert(file.parent_path()).second) return;
    spdlog::warn("nothing can be kept in the cache, so the next run computes it again: {}",
                 error.what());
  }
}

}  // namespace carillon::core
