#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "cli/build/build.hpp"
#include "cli/build/modes_task.hpp"
#include "cli/build/progress_so_far.hpp"
#include "core/trace.hpp"

namespace carillon::cli {

/// Keeps index.h5, dataset.json and failures.json at what is done while a build runs, in a thread
/// of the host. Each is replaced as a whole, so that a reader finds either the old or the new one.
/// All writing together takes at most `share` of the time since the beginning and `grace` more, so
/// that an index that grows is written less often.
class IndexKeeper {
 public:
  static constexpr double share = 0.01;
  static constexpr double grace = 0.3;  ///< [s], so that short builds have one too

  /// Writes what is done already at once. `build` and `folders` must outlive it.
  /// @param finished  as in write_results
  IndexKeeper(const LoadedBuild& build, const BuildFolders& folders,
              std::map<std::string, nlohmann::json> finished);
  ~IndexKeeper();
  IndexKeeper(const IndexKeeper&) = delete;
  IndexKeeper& operator=(const IndexKeeper&) = delete;

  /// A task ended; `entry` is its journal entry. Returns at once.
  void add(const nlohmann::json& entry);
  /// Writes what is not written yet, whatever it takes. An error is warned of, once: the build
  /// itself will meet it where it matters.
  Results write_now();
  /// Nothing is written any more.
  void end();
  /// Times that all three were written, and what that took together [s].
  core::Trace::Entry cost() const { return {calls_, spent_}; }

 private:
  void run();
  bool due() const;

  const LoadedBuild& build_;
  const BuildFolders& folders_;
  std::thread thread_;

  mutable std::mutex news_mutex_;
  std::condition_variable woken_;
  std::vector<nlohmann::json> news_;  ///< not in finished_ yet
  bool ending_ = false;

  std::mutex write_mutex_;  ///< of all below
  std::map<std::string, nlohmann::json> finished_;
  Results results_;
  bool written_ = false;
  bool told_ = false;
  bool ended_ = false;

  const double begin_;
  std::atomic<std::int64_t> calls_ = 0;
  std::atomic<double> spent_ = 0;
  std::atomic<double> last_ = 0;  ///< what the last writing took [s]
};

}  // namespace carillon::cli
