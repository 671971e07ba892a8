#pragma once

#include <condition_variable>
#include <exception>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>

namespace carillon::dataset::run {

/// Keeps status.json (dataset/run/status.hpp) at what a run does: once a second where something is
/// new, and every few seconds in any case, so that its date tells that the run is alive. A file
/// that cannot be written ends nothing.
class StatusFile {
 public:
  /// @param head  what stays as it is while the run goes on
  /// @param now   as in update()
  StatusFile(const std::filesystem::path& folder, nlohmann::ordered_json head,
             nlohmann::ordered_json now);
  /// A run that has not ended by then was broken off by an error.
  ~StatusFile();
  StatusFile(const StatusFile&) = delete;
  StatusFile& operator=(const StatusFile&) = delete;

  void update(nlohmann::ordered_json now);
  /// How it ended, with what was updated last. Once; later calls change nothing.
  /// @param state      "done", "interrupted" or "error"
  /// @param exit_code  of the program
  void end(std::string_view state, int exit_code);
  /// @param error  that ends the run
  void fail(const std::exception_ptr& error);

 private:
  void keep();
  void write();

  const std::filesystem::path path_;
  nlohmann::ordered_json head_, now_, end_;
  bool news_ = true;
  bool ended_ = false;
  std::mutex mutex_;
  std::condition_variable woken_;
  std::thread keeper_;
};

}  // namespace carillon::dataset::run
