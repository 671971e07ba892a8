#include "solvers/mesher/detail/ask_child.hpp"

#include <fmt/core.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string_view>

#include "core/child_process.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/near_program.hpp"
#include "core/progress.hpp"
#include "core/storage_error.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::solvers::mesher {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* folder_hint =
    "make room, or set TMPDIR to a folder that may be written to, on every node; then run the same "
    "command again";

fs::path worker_program() {
  if (const char* named = std::getenv("CARILLON_MESH"); named != nullptr && *named != '\0') {
    if (fs::exists(named)) return named;
    throw core::StorageError(fmt::format("CARILLON_MESH names {}, which does not exist", named),
                             "name carillon-mesh, or nothing where it lies beside carillon");
  }
  if (const fs::path found = core::find_helper("carillon-mesh"); !found.empty()) return found;
  throw core::StorageError(
      "carillon-mesh is missing",
      "install carillon and have it in PATH, or name carillon-mesh in CARILLON_MESH");
}

/// The last lines of the child's output, set off for a message.
std::string quoted_tail(const std::string& output) {
  std::size_t begin = output.size();
  for (int lines = 0; lines < 6 && begin != std::string::npos && begin > 0; ++lines) {
    begin = output.rfind('\n', begin - 1);
  }
  const std::string tail = output.substr(begin == std::string::npos ? 0 : begin);
  if (tail.find_first_not_of(" \r\n\t") == std::string::npos) return "";
  return "\n  its last words: " + tail.substr(tail.find_first_not_of("\r\n"));
}

[[noreturn]] void throw_reported(const json& error, const std::string& what,
                                 const ChildLimits& limits) {
  const std::string kind = error.at("kind");
  const std::string message = error.at("message");
  const std::string hint = error.at("hint");
  if (kind == "input") throw core::InputError(message, hint);
  if (kind == "file") throw core::FileError(message, hint);
  if (kind == "limit") throw core::LimitError(message, hint);
  if (kind == "memory") {
    throw core::MemoryError(
        fmt::format("{}: meshing needs more than the limit of {}", what,
                    core::human_bytes(static_cast<double>(limits.memory))),
        "a larger element size or a simpler surface needs less; or raise limits.mesh_memory");
  }
  throw core::SolverError(message, hint);
}

/// Throws what a child without a reply died of.
[[noreturn]] void throw_death(const core::ChildExit& exit, const std::string& what,
                              const ChildLimits& limits) {
  const std::string tail = quoted_tail(exit.output);
  if (exit.timed_out) {
    throw core::TimeError(fmt::format("{}: meshing was stopped at the time limit of {}{}", what,
                                      core::human_duration(limits.seconds), tail),
                          "a larger element size is faster; or raise limits.mesh_time");
  }
  if (exit.signal != 0) {
    const char* name = sigabbrev_np(exit.signal);
    throw core::SolverError(
        fmt::format("{}: the mesher crashed after {} (signal {}, SIG{}){}", what,
                    core::human_duration(exit.seconds), exit.signal, name ? name : "?", tail),
        exit.signal == SIGKILL ? "the system may have run out of memory" : "");
  }
  if (exit.code == mesher_without_storage) {
    throw core::StorageError(
        fmt::format("{}: the mesher cannot read or write its files{}", what, tail), folder_hint);
  }
  throw core::SolverError(
      fmt::format("{}: the mesher ended with code {} and no answer{}", what, exit.code, tail));
}

}  // namespace

json ask_child(json question, const std::string& what, const ChildLimits& limits) {
  const core::TemporaryFolder folder;
  const fs::path file = folder / "request.cbor";
  const fs::path reply = folder / "reply.cbor";
  question["memory"] = limits.memory;
  question["parent"] = getpid();
  const auto bytes = json::to_cbor(question);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) {
    throw core::StorageError(fmt::format("{}: cannot be written", file.string()), folder_hint);
  }

  const core::ChildExit exit =
      core::run_child(worker_program(), {file.string(), reply.string()}, limits.seconds);
  if (exit.timed_out || exit.signal != 0 || exit.code != 0 || !fs::exists(reply)) {
    throw_death(exit, what, limits);
  }
  json answer = json::from_cbor(core::read_file(reply), true, false);
  if (answer.is_discarded()) throw_death(exit, what, limits);
  if (answer.contains("error")) throw_reported(answer.at("error"), what, limits);
  return std::move(answer.at("result"));
}

}  // namespace carillon::solvers::mesher
