#include "solvers/mesh/tetrahedra/detail/made_apart.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <exception>
#include <new>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.hpp"
#include "solvers/mesh/shape_source.hpp"

namespace carillon::solvers::mesh::tetrahedra {
namespace {

enum class Outcome : char { made, failed, out_of_memory };

std::string answer(const std::function<TetMesh()>& make) {
  const auto failed = [](const std::string& message) {
    return static_cast<char>(Outcome::failed) + message;
  };
  try {
    MeshResult result;
    result.mesh = make();
    std::string bytes(1, static_cast<char>(Outcome::made));
    nlohmann::json::to_cbor(to_json(result), bytes);
    return bytes;
  } catch (const core::Error& error) {
    return failed(error.message());
  } catch (const std::bad_alloc&) {
    return std::string(1, static_cast<char>(Outcome::out_of_memory));
  } catch (const std::exception& error) {
    return failed(error.what());
  }
}

[[noreturn]] void answer_and_end(int pipe, const std::function<TetMesh()>& make, unsigned seconds) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGXCPU}) ::signal(signal, SIG_DFL);
  const rlimit no_core{0, 0}, time{seconds, seconds + 1};
  setrlimit(RLIMIT_CORE, &no_core);
  setrlimit(RLIMIT_CPU, &time);
  const std::string bytes = answer(make);
  for (std::size_t sent = 0; sent < bytes.size();) {
    const ssize_t count = write(pipe, bytes.data() + sent, bytes.size() - sent);
    if (count < 0 && errno != EINTR) _exit(1);
    if (count > 0) sent += static_cast<std::size_t>(count);
  }
  _exit(0);
}

std::string all_of(int pipe) {
  std::string bytes;
  std::array<char, 65536> part;
  while (true) {
    const ssize_t count = read(pipe, part.data(), part.size());
    if (count > 0) bytes.append(part.data(), static_cast<std::size_t>(count));
    if (count == 0 || (count < 0 && errno != EINTR)) return bytes;
  }
}

}  // namespace

TetMesh made_apart(const std::function<TetMesh()>& make, unsigned seconds) {
  int ends[2];
  if (pipe(ends) != 0) throw core::SolverError("no pipe to a mesher's process can be had");
  const pid_t child = fork();
  if (child < 0) {
    close(ends[0]);
    close(ends[1]);
    throw core::SolverError("no process can be started for a mesher");
  }
  if (child == 0) {
    close(ends[0]);
    answer_and_end(ends[1], make, seconds);
  }
  close(ends[1]);
  const std::string bytes = all_of(ends[0]);
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGXCPU)
      throw core::SolverError(fmt::format("it was stopped after {} s", seconds));
    const char* name = sigabbrev_np(signal);
    throw core::SolverError(fmt::format("it crashed (SIG{})", name != nullptr ? name : "?"));
  }
  if (WEXITSTATUS(status) != 0 || bytes.empty())
    throw core::SolverError("it ended without an answer");
  if (bytes[0] == static_cast<char>(Outcome::out_of_memory)) throw std::bad_alloc();
  if (bytes[0] == static_cast<char>(Outcome::failed)) throw core::SolverError(bytes.substr(1));
  return mesh_result_from_json(nlohmann::json::from_cbor(bytes.begin() + 1, bytes.end())).mesh;
}

}  // namespace carillon::solvers::mesh::tetrahedra
