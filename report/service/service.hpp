#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "report/service/http_server.hpp"

namespace carillon::report::service {

/// What trained networks say of a clip, as `carillon identify --json` tells it of one. Asked by one
/// thread at a time.
using Identify = std::function<nlohmann::ordered_json(const std::filesystem::path& clip)>;

struct ServiceOptions {
  std::vector<std::string> folders;  ///< as `carillon report` takes them; nothing else is served
  std::string host = "127.0.0.1";
  int port = 8750;           ///< 0: any that is free
  std::string token;         ///< that requests must have; "": none
  std::size_t waiting = 64;  ///< computations that wait for others; more are refused with 503
  double longest_clip = 60;  ///< [s]
  HttpLimits http;
  nlohmann::ordered_json made;  ///< mpi::made_by()
  Identify identify;            ///< empty: there are no networks
};

/// The report's page and the commands that answer for sounds, by HTTP (docs/service.md). Folders'
/// contents are looked for anew as they change; nothing of them is written. One computation runs at
/// a time: OpenBLAS for single threads, which a rank wants, is not made for several that call it at
/// once, and gives wrong numbers then.
class Service {
 public:
  /// @throws InputError  a folder that is not there; an address beyond this machine without a token
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
