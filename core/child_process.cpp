#include "core/child_process.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/storage_error.hpp"
#include "core/trace.hpp"

extern char** environ;

namespace carillon::core {
namespace {

constexpr std::size_t kept_output = 4096;
/// How long a poll sleeps at most [s].
constexpr double max_poll_s = 0.02;
/// How often a child is looked after that has closed its streams [s]: as a rule it is about to end,
/// and whoever waits for it has nothing else to do.
constexpr double last_step = 0.001;

struct SpawnActions {
  posix_spawn_file_actions_t raw;
  SpawnActions() { posix_spawn_file_actions_init(&raw); }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;
  ~SpawnActions() { posix_spawn_file_actions_destroy(&raw); }
};

struct SpawnAttributes {
  posix_spawnattr_t raw;
  SpawnAttributes() { posix_spawnattr_init(&raw); }
  SpawnAttributes(const SpawnAttributes&) = delete;
  SpawnAttributes& operator=(const SpawnAttributes&) = delete;
  ~SpawnAttributes() { posix_spawnattr_destroy(&raw); }
};

/// Takes what there is to read; false at the end of the stream.
bool take_output(int fd, std::string& output) {
  std::array<char, 4096> block;
  const ssize_t got = read(fd, block.data(), block.size());
  if (got < 0) return errno == EINTR || errno == EAGAIN;
  output.append(block.data(), static_cast<std::size_t>(got));
  if (output.size() > kept_output) output.erase(0, output.size() - kept_output);
  return got > 0;
}

}  // namespace

ChildPipe::ChildPipe() {
  if (pipe2(ends_.data(), O_CLOEXEC) != 0) {
    throw StorageError(fmt::format("no pipe to a child process: {}", std::strerror(errno)),
                       "more files are open than the system lets be: see ulimit -n");
  }
}

ChildPipe::~ChildPipe() {
  close_end(0);
  close_end(1);
}

void ChildPipe::close_end(std::size_t end) {
  if (ends_.at(end) >= 0) close(ends_.at(end));
  ends_.at(end) = -1;
}

pid_t start_child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                  const ChildStreams& streams, bool heeds_signals) {
  SpawnActions actions;
  if (streams.input < 0) {
    posix_spawn_file_actions_addopen(&actions.raw, 0, "/dev/null", O_RDONLY, 0);
  } else {
    posix_spawn_file_actions_adddup2(&actions.raw, streams.input, 0);
  }
  posix_spawn_file_actions_adddup2(&actions.raw, streams.output, 1);
  posix_spawn_file_actions_adddup2(&actions.raw, streams.error, 2);
  posix_spawn_file_actions_addclosefrom_np(&actions.raw, 3);

  SpawnAttributes attributes;
  // Batch systems send their requests to stop to every process of a job. They are the caller's to
  // answer: a child that ended by one would look like a crash.
  sigset_t ignored;
  sigset_t all;
  sigemptyset(&ignored);
  for (const int request : {SIGINT, SIGTERM, SIGUSR1}) {
    if (!heeds_signals) sigaddset(&ignored, request);
  }
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes.raw, &ignored);
  posix_spawnattr_setsigdefault(&attributes.raw, &all);
  posix_spawnattr_setpgroup(&attributes.raw, 0);
  posix_spawnattr_setflags(&attributes.raw,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);

  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> raw_words;
  for (std::string& word : words) raw_words.push_back(word.data());
  raw_words.push_back(nullptr);
  pid_t pid = 0;
  const int error =
      posix_spawn(&pid, program.c_str(), &actions.raw, &attributes.raw, raw_words.data(), environ);
  if (error != 0) {
    throw StorageError(
        fmt::format("{}: cannot be started: {}", program.string(), std::strerror(error)),
        "see to it that the machine can, then run the same command again");
  }
  return pid;
}

ChildExit run_child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                    double seconds) {
  ChildPipe pipe;
  const double start = monotonic_seconds();
  const double deadline = seconds > 0 ? start + seconds : std::numeric_limits<double>::infinity();
  const pid_t pid = start_child(program, arguments, {-1, pipe.end(1), pipe.end(1)});
  pipe.close_end(1);

  ChildExit exit;
  bool streaming = true;
  int status = 0;
  for (;;) {
    const pid_t ended = waitpid(pid, &status, WNOHANG);
    if (ended == pid) break;
    if (ended < 0 && errno != EINTR) {
      // Someone else has waited for it (SIGCHLD ignored); its reply alone tells how it went.
      status = 0;
      break;
    }
    const double left = deadline - monotonic_seconds();
    if (left <= 0 && !exit.timed_out) {
      exit.timed_out = true;
      kill(pid, SIGKILL);
    }
    pollfd waiting{pipe.end(0), POLLIN, 0};
    const int milliseconds = static_cast<int>(
        std::ceil(1000 * std::clamp(left, 0.001, streaming ? max_poll_s : last_step)));
    if (poll(&waiting, streaming ? 1 : 0, milliseconds) > 0) {
      streaming = take_output(pipe.end(0), exit.output);
    }
  }
  // What was printed last is still in the pipe; nobody else holds its other end.
  while (streaming) {
    pollfd rest{pipe.end(0), POLLIN, 0};
    streaming = poll(&rest, 1, 0) > 0 && take_output(pipe.end(0), exit.output);
  }
  exit.seconds = monotonic_seconds() - start;
  if (WIFSIGNALED(status)) exit.signal = WTERMSIG(status);
  if (WIFEXITED(status)) exit.code = WEXITSTATUS(status);
  return exit;
}

}  // namespace carillon::core
