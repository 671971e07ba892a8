#include "core/data_limit.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <mutex>

#include "core/error.hpp"
#include "core/sanitizers.hpp"

namespace carillon::core {

namespace {

/// The limit belongs to the process, and so does what is known of it.
struct Limit {
  std::mutex mutex;
  bool lives = false;
  int resting = 0;
  rlimit former{};
  rlim_t bytes = 0;

  bool apply() const {
    rlimit now = former;
    if (resting == 0) now.rlim_cur = std::min(bytes, former.rlim_max);
    return setrlimit(RLIMIT_DATA, &now) == 0;
  }
};

Limit& limit() {
  static Limit of_process;
  return of_process;
}

}  // namespace

DataLimit::DataLimit(std::int64_t bytes) {
  if (bytes <= 0 || address_sanitizer) return;
  const std::scoped_lock lock(limit().mutex);
  if (limit().lives) throw Error("two limits of a process's data at a time");
  if (getrlimit(RLIMIT_DATA, &limit().former) != 0) return;
  limit().bytes = static_cast<rlim_t>(bytes);
  set_ = limit().lives = limit().apply();
}

DataLimit::~DataLimit() {
  if (!set_) return;
  const std::scoped_lock lock(limit().mutex);
  setrlimit(RLIMIT_DATA, &limit().former);
  limit().lives = false;
}

DataLimitRests::DataLimitRests() {
  const std::scoped_lock lock(limit().mutex);
  if (++limit().resting == 1 && limit().lives) limit().apply();
}

DataLimitRests::~DataLimitRests() {
  const std::scoped_lock lock(limit().mutex);
  if (--limit().resting == 0 && limit().lives) limit().apply();
}

}  // namespace carillon::core
