#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "report/service/http_server.hpp"
#include "report/service/jobs/launch.hpp"
#include "report/service/worker_pool.hpp"

namespace carillon::report::service {

struct ServiceOptions {
  std::vector<std::string> folders;  ///< as `carillon report` takes them; nothing else is served
  std::string host = "127.0.0.1";
  int port = 8750;    ///< 0: any that is free
  std::string token;  ///< that requests must have; "": none
  HttpLimits http;
  nlohmann::ordered_json made;  ///< `command` as it was typed, `carillon` as version
  WorkerOptions workers;        ///< that compute
  // Jobs.
  std::string jobs;                ///< their folder; "": none are taken
  std::vector<std::string> seals;  ///< of datasets whose test labels are hidden
  std::string cache;               ///< of meshes and modes
  int ranks = 1;                   ///< of a job, at the most
  Launcher launcher = Launcher::mpirun;
  std::size_t max_jobs = 100;  ///< that are not over
};

/// The report's page and the commands that answer for sounds, by HTTP (docs/service.md,
/// share/carillon/openapi.json). Folders' contents are looked for anew as they change; only jobs
/// write, in their own folder and, of scores, in their dataset's `evaluation/`.
class Service {
 public:
  /// @throws InputError  a folder that is not there; an address beyond this machine without a
  ///                     token; workers that cannot start
  explicit Service(ServiceOptions options);
  ~Service();

  /// The port that it listens at.
  int port() const;
  /// Answers until stop().
  void run();
  /// From any thread.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace carillon::report::service
