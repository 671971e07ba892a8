#include "report/service/worker_pool.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <optional>
#include <thread>

#include "core/child_process.hpp"
#include "core/error.hpp"
#include "core/trace.hpp"
#include "report/service/detail/frames.hpp"

namespace carillon::report::service {

namespace {

constexpr double ready_within = 120;  ///< [s] networks are loaded in seconds
constexpr double ends_within = 5;     ///< [s] once its requests have ended

}  // namespace

class WorkerPool::Worker {
 public:
  ~Worker() { end(ends_within); }

  /// Starts it where it does not run.
  /// @throws InputError  it has ended before it was ready
  void start(const WorkerOptions& options, bool& identifies) {
    if (frames_) return;
    {
      core::ChildPipe questions, answers;
      pid_ = core::start_child(options.program, options.arguments,
                               {questions.end(0), answers.end(1), 2});
      question_ = questions.take(1);
      answer_ = answers.take(0);
    }
    frames_.emplace(answer_, question_);
    try {
      identifies = nlohmann::json::parse(frames_->reply(ready_within).body).at("identify");
    } catch (const std::exception& error) {
      throw core::InputError(fmt::format(
          "{} cannot answer: {}, {}", options.program.filename().string(), error.what(), end(0)));
    }
  }

  HttpReply ask(const HttpRequest& request, const WorkerOptions& options) {
    try {
      bool ready = false;
      if (frames_ && has_ended()) end(0);  // while it had nothing to do
      start(options, ready);
      const double begin = core::monotonic_seconds();
      frames_->send(request);
      try {
        return frames_->reply(options.seconds);
      } catch (const core::FileError&) {
        const bool late = core::monotonic_seconds() - begin >= options.seconds;
        const std::string how = end(late ? 0 : 1);
        if (late) {
          return error_reply(504,
                             fmt::format("the answer takes longer than {:g} s", options.seconds),
                             "carillon serve --time-limit");
        }
        return error_reply(500, fmt::format("what computed the answer has ended: {}", how),
                           "other requests are answered by another");
      }
    } catch (const core::Error& error) {
      return error_reply(500, error.message(), error.hint());
    }
  }

 private:
  bool has_ended() const {
    siginfo_t info{};
    return waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 ||
           info.si_pid != 0;
  }

  /// Gives it `seconds` to end by itself.
  /// @return how it ended
  std::string end(double seconds) {
    frames_.reset();
    for (int* stream : {&question_, &answer_}) {
      if (*stream >= 0) ::close(*stream);
      *stream = -1;
    }
    if (pid_ <= 0) return "it was not started";
    int status = 0;
    const double deadline = core::monotonic_seconds() + seconds;
    pid_t ended = 0;
    while ((ended = waitpid(pid_, &status, WNOHANG)) == 0 && core::monotonic_seconds() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    if (ended == 0) {
      kill(-pid_, SIGKILL);  // with what it has started
      while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
      }
    }
    pid_ = 0;
    if (WIFSIGNALED(status)) {
      return fmt::format("signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
    }
    return fmt::format("exit code {}", WEXITSTATUS(status));
  }

  pid_t pid_ = 0;
  int question_ = -1, answer_ = -1;
  std::optional<Frames> frames_;
};

WorkerPool::WorkerPool(WorkerOptions options) : options_(std::move(options)) {
  for (std::size_t i = 0; i < options_.count; ++i) workers_.push_back(std::make_unique<Worker>());
  // Each loads for itself: all at once.
  std::vector<std::exception_ptr> errors(workers_.size());
  std::vector<std::thread> starting;
  for (std::size_t i = 0; i < workers_.size(); ++i) {
    starting.emplace_back([this, i, &errors] {
      bool identifies = false;
      try {
        workers_[i]->start(options_, identifies);
      } catch (...) {
        errors[i] = std::current_exception();
      }
      const std::lock_guard lock(mutex_);
      identifies_ = identifies_ || identifies;
    });
  }
  for (std::thread& one : starting) one.join();
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
  for (const auto& worker : workers_) idle_.push_back(worker.get());
}

WorkerPool::~WorkerPool() = default;

HttpReply WorkerPool::ask(const HttpRequest& request) {
  Worker* worker = nullptr;
  {
    std::unique_lock lock(mutex_);
    if (idle_.empty()) {
      if (waiting_ == options_.waiting) {
        return error_reply(503, "too many requests wait already", "try again later");
      }
      ++waiting_;
      left_.wait(lock, [this] { return !idle_.empty(); });
      --waiting_;
    }
    worker = idle_.back();  // the one that worked last is warm
    idle_.pop_back();
  }
  // Whatever is thrown, it is free again.
  const std::shared_ptr<void> place(nullptr, [&](void*) {
    {
      const std::lock_guard lock(mutex_);
      idle_.push_back(worker);
    }
    left_.notify_one();
  });
  return worker->ask(request, options_);
}

}  // namespace carillon::report::service
