#include "cli/on_finish.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include "core/error.hpp"

namespace carillon::cli {

namespace {

constexpr const char* killed_code = "137";  // as a shell tells SIGKILL

/// What the watcher is told, until the program and its pipe are gone.
std::string read_all(int pipe) {
  std::string notes;
  std::array<char, 512> block;
  for (;;) {
    const ssize_t got = read(pipe, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return notes;
    notes.append(block.data(), static_cast<std::size_t>(got));
  }
}

/// The value of the last line with a name; "" where there is none.
std::string last_of(const std::string& notes, const std::string& name) {
  const std::size_t at = ("\n" + notes).rfind("\n" + name + " ");
  if (at == std::string::npos) return "";
  const std::size_t begin = at + name.size() + 1;
  return notes.substr(begin, notes.find('\n', begin) - begin);
}

/// The watcher's life.
[[noreturn]] void wait_and_run(int pipe, const char* command) {
  // Neither Ctrl-C nor what else ends the program's group of processes ends it too.
  setsid();
  for (const int request : {SIGINT, SIGTERM, SIGUSR1, SIGHUP}) std::signal(request, SIG_DFL);
  const std::string notes = read_all(pipe);
  const std::string code = last_of(notes, "exit");
  setenv("CARILLON_EXIT_CODE", code.empty() ? killed_code : code.c_str(), 1);
  if (const std::string output = last_of(notes, "output"); !output.empty())
    setenv("CARILLON_OUTPUT", output.c_str(), 1);
  execl("/bin/sh", "sh", "-c", command, nullptr);
  _exit(127);
}

}  // namespace

void OnFinish::watch(const std::string& command) {
  if (command.empty()) return;
  std::array<int, 2> ends{-1, -1};
  if (pipe2(ends.data(), O_CLOEXEC) != 0 || (watcher_ = fork()) < 0) {
    throw core::FileError(
        fmt::format("no process for --on-finish can be started: {}", std::strerror(errno)),
        "see ulimit -u and -n, or do without");
  }
  if (watcher_ == 0) {
    close(ends[1]);
    wait_and_run(ends[0], command.c_str());
  }
  close(ends[0]);
  pipe_ = ends[1];
}

OnFinish::~OnFinish() {
  if (pipe_ >= 0) close(pipe_);
}

void OnFinish::note(std::string line) {
  if (pipe_ < 0) return;
  line += '\n';
  // Fits into the pipe, whose other end reads; without it the program works all the same.
  if (write(pipe_, line.data(), line.size()) < 0)
    spdlog::debug("--on-finish: {}", std::strerror(errno));
}

void OnFinish::finish(int code) {
  if (pipe_ < 0) return;
  note_exit(code);
  close(pipe_);
  pipe_ = -1;
  int status = 0;
  while (waitpid(watcher_, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) != 0)
    spdlog::warn("the command of --on-finish ended with code {}", WEXITSTATUS(status));
  else if (WIFSIGNALED(status))
    spdlog::warn("the command of --on-finish was ended by signal {}", WTERMSIG(status));
}

}  // namespace carillon::cli
