#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "report/service/jobs/job.hpp"
#include "report/service/jobs/launch.hpp"

namespace carillon::report::service {

struct JobQueueOptions {
  std::filesystem::path folder;   ///< made where it is not there
  std::filesystem::path program;  ///< carillon
  Launcher launcher = Launcher::mpirun;
  std::size_t longest = 100;  ///< jobs that are not over; more are refused
};

/// A command for the queue.
struct JobRequest {
  std::string command;
  std::vector<std::string> arguments;
  std::map<std::string, std::string> files{};  ///< in the job's folder, by name
  int ranks = 1;
};

/// Jobs on disk, each in a folder that is called by its number: those that have ranks run one after
/// another, or when Slurm lets them, and scores one after another beside them. What runs is found
/// again when the service has been killed, and goes on later when it was stopped.
class JobQueue {
 public:
  /// @throws FileError  another service has the folder
  explicit JobQueue(JobQueueOptions options);
  /// Asks what runs on this machine to stop, and waits for it: it is queued again.
  ~JobQueue();
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  /// @return its document
  /// @throws StorageError  it cannot be written
  /// @throws InputError    too many wait
  nlohmann::ordered_json submit(const JobRequest& request);
  std::optional<nlohmann::ordered_json> find(int id) const;
  /// All, the newest first, without results.
  nlohmann::ordered_json all() const;
  /// @return its document; nothing: there is no such job
  /// @throws InputError  it is over
  std::optional<nlohmann::ordered_json> cancel(int id);

 private:
  /// Jobs of which one runs at a time.
  enum Lane { ranks, scores, lanes };
  static Lane lane_of(const Job& job) { return job.command == "score" ? scores : ranks; }

  std::filesystem::path folder_of(int id) const;
  void load();
  void run(Lane lane);
  static std::string outside(std::unique_lock<std::mutex>& lock, int id,
                             const std::function<void()>& action);
  void look_after(Lane lane, std::unique_lock<std::mutex>& lock);
  bool is_busy(Lane lane) const;
  void start_next(Lane lane, std::unique_lock<std::mutex>& lock);
  void start(Job& job, std::unique_lock<std::mutex>& lock);
  void settle(Job& job, const JobProcess& process);
  void save(const Job& job);

  JobQueueOptions options_;
  int lock_ = -1;
  mutable std::mutex mutex_;
  std::condition_variable woken_;
  std::map<int, Job> jobs_;
  int last_ = 0;                 ///< number that was given
  std::map<int, double> asked_;  ///< when running ones were asked to stop [s, monotonic]
  std::set<int> starting_;       ///< just now
  bool stopping_ = false;
  std::array<std::thread, lanes> threads_;
};

}  // namespace carillon::report::service
