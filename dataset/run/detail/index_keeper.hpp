#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/trace.hpp"
#include "dataset/run/build.hpp"
#include "dataset/run/progress_so_far.hpp"
#include "dataset/samples/modes_task.hpp"

namespace carillon::dataset::run {

/// A build whose files are kept at what is done; both must outlive the keeper.
struct KeptIndex {
  const LoadedBuild* build = nullptr;
  const samples::BuildFolders* folders = nullptr;
  std::map<std::string, nlohmann::json> finished{};  ///< as in write_results
};

/// Keeps index.h5, dataset.json and failures.json at what is done while builds run, in a thread
/// of the host. Each is replaced as a whole, so that a reader finds either the old or the new one.
/// All writing together takes at most `fraction` of the time since the beginning and `grace` more,
/// so that an index that grows is written less often. Each file that is joined is read once, soon
/// after its task has ended: a writing that cannot wait reads hardly any.
class IndexKeeper {
 public:
  static constexpr double fraction = 0.01;
  static constexpr double grace = 0.3;  ///< [s], so that short builds have one too

  /// Begins with what is done already.
  explicit IndexKeeper(std::vector<KeptIndex> builds);
  ~IndexKeeper();
  IndexKeeper(const IndexKeeper&) = delete;
  IndexKeeper& operator=(const IndexKeeper&) = delete;

  /// A task of a build ended; `entry` is its journal entry. Returns at once.
  void add(std::size_t build, const nlohmann::json& entry);
  /// Writes what is not written yet, whatever it takes. An error is warned of, once: the builds
  /// themselves will meet it where it matters.
  /// @return what each folder holds
  std::vector<Results> write_now();
  /// Nothing is written any more.
  void end();
  /// Ends, and writes what is not written yet.
  /// @return what each folder holds
  /// @throws StorageError, FileError  it cannot be written, or a shard not be read
  std::vector<Results> finish();
  /// Times that the three of a build were written, and what that took together [s].
  core::Trace::Entry cost() const { return {calls_, spent_}; }

 private:
  struct News {
    std::size_t build;
    nlohmann::json entry;
  };
  void run();
  bool due() const;
  bool is_ending() const;
  void take_news();
  void read_files();
  void write(std::size_t build);
  void write_next();

  std::thread thread_;

  mutable std::mutex news_mutex_;
  std::condition_variable woken_;
  std::vector<News> news_;  ///< not in `finished` yet
  bool ending_ = false;

  mutable std::mutex write_mutex_;  ///< of all below
  std::vector<KeptIndex> builds_;
  std::vector<JoinedFiles> joined_;  ///< of each build
  /// Files that have not been looked at, by build.
  std::vector<std::pair<std::size_t, std::string>> unread_;
  std::set<std::size_t> behind_;  ///< builds whose files do not hold all that is finished
  std::set<std::size_t> failed_;  ///< builds whose last writing did not go well
  std::vector<Results> results_;
  bool told_ = false;
  bool ended_ = false;

  const double begin_;
  std::atomic<std::int64_t> calls_ = 0;
  std::atomic<double> spent_ = 0;
  std::atomic<double> last_ = 0;  ///< what the last writing took [s]
};

}  // namespace carillon::dataset::run
