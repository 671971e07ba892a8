#pragma once

#include <condition_variable>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "report/service/http_message.hpp"

namespace carillon::report::service {

struct WorkerOptions {
  std::filesystem::path program;
  std::vector<std::string> arguments;  ///< with which it runs answer_requests() on its streams
  std::size_t count = 1;
  std::size_t waiting = 64;  ///< requests that wait for a worker; more are refused with 503
  double seconds = 120;      ///< an answer may take
};

/// Processes that answer requests, each one at a time: what a request makes crash or hang is its
/// own process, and another takes its place.
class WorkerPool {
 public:
  /// Starts them all, and waits until they have loaded what they need.
  /// @throws InputError    one of them has ended instead; it has said why on standard error
  /// @throws StorageError  one cannot be started
  explicit WorkerPool(WorkerOptions options);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// From any thread.
  /// @return 503: too many wait; 504: it took too long; 500: the worker has ended
  HttpReply ask(const HttpRequest& request);
  /// They have trained networks.
  bool identifies() const { return identifies_; }

 private:
  class Worker;

  WorkerOptions options_;
  bool identifies_ = false;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::mutex mutex_;
  std::condition_variable left_;
  std::vector<Worker*> idle_;
  std::size_t waiting_ = 0;
};

}  // namespace carillon::report::service
