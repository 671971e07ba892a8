#include "python/runtime.hpp"

#include <pthread.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <new>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/failure.hpp"
#include "mpi/comm.hpp"
#include "mpi/launcher.hpp"
#include "solvers/libraries/environment.hpp"
#include "solvers/libraries/one_thread.hpp"

namespace carillon::python {

namespace {

/// Keeps warnings until Python can have them.
class KeptWarnings final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  std::vector<std::string> take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(texts_, {});
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (message.level >= spdlog::level::warn) {
      texts_.emplace_back(message.payload.data(), message.payload.size());
    }
  }
  void flush_() override {}

 private:
  std::vector<std::string> texts_;
};

std::shared_ptr<KeptWarnings>& kept_warnings() {
  static auto kept = std::make_shared<KeptWarnings>();
  return kept;
}

/// What runs while modes can be solved, and the process that started it.
struct Solver {
  std::optional<mpi::Environment> mpi{};
  std::optional<solvers::libraries::SolverEnvironment> environment{};
  pid_t process = getpid();
};

/// Takes back the variables that a library adds to the environment while one lives: a launcher that
/// Python starts later would take itself for a part of this process' MPI.
class SameEnvironment {
 public:
  SameEnvironment() : before_(names()) {}
  ~SameEnvironment() {
    for (const std::string& name : names()) {
      if (!before_.contains(name)) unsetenv(name.c_str());
    }
  }
  SameEnvironment(const SameEnvironment&) = delete;
  SameEnvironment& operator=(const SameEnvironment&) = delete;

 private:
  static std::set<std::string> names() {
    std::set<std::string> all;
    for (char** variable = environ; *variable != nullptr; ++variable) {
      const std::string_view text(*variable);
      all.emplace(text.substr(0, text.find('=')));
    }
    return all;
  }
  std::set<std::string> before_;
};

std::optional<Solver>& solver() {
  static std::optional<Solver> running;
  return running;
}

/// Ends the process at once, without the destructors of what a thread still works with.
void leave(int status, void*) {
  std::fflush(nullptr);
  _exit(status);
}

void end_solver() {
  constexpr std::chrono::milliseconds grace(500);
  const py::gil_scoped_release unlocked;
  const std::unique_lock lock(turn(), grace);
  if (!lock) {
    // Work that nobody waits for any more.
    on_exit(leave, nullptr);
    return;
  }
  auto& running = solver();
  if (!running || running->process != getpid()) return;
  running->environment.reset();
  running->mpi.reset();
}

// By value: as pybind11 calls it. NOLINTNEXTLINE(performance-unnecessary-value-param)
void translate(std::exception_ptr pointer) {
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const core::Error&) {
    const core::Failure failure = core::describe(pointer);
    const py::object type =
        py::module_::import("carillon.errors").attr("error_class")(failure.kind);
    PyErr_SetObject(type.ptr(), py::make_tuple(failure.message, failure.hint).ptr());
  } catch (const nlohmann::json::exception& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
  }
}

}  // namespace

core::TimeLimit Waiting::limit(const std::string& work) const {
  core::TimeLimit limit;
  limit.work = work;
  limit.given_up = [waiting = *this] { return waiting.given_up(); };
  return limit;
}

std::timed_mutex& turn() {
  static std::timed_mutex mutex;
  // A forked child has none of the threads that may have held it.
  static const int heeded =
      pthread_atfork(nullptr, nullptr, [] { new (&turn()) std::timed_mutex; });
  static_cast<void>(heeded);
  return mutex;
}

std::unique_lock<std::timed_mutex> wait_for_turn() {
  std::unique_lock lock(turn(), std::defer_lock);
  for (;;) {
    {
      const py::gil_scoped_release unlocked;
      if (lock.try_lock_for(look)) return lock;
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

void start_solver() {
  const auto lock = wait_for_turn();
  auto& running = solver();
  if (running && running->process == getpid()) return;
  if (running) {
    throw core::Error("this process was forked from one that had solved modes, which MPI forbids",
                      "use multiprocessing's \"spawn\", or solve in the workers alone");
  }
  running.emplace();
  int started = 0;
  MPI_Initialized(&started);
  if (started == 0) {
    const SameEnvironment same;
    const mpi::AloneSettings settings;
    static char name[] = "carillon";
    static char* arguments[] = {name, nullptr};
    int count = 1;
    char** values = arguments;
    running->mpi.emplace(count, values);
  }
  // PETSc's start sets how many threads OpenMP gives this thread, which is Python's.
  const solvers::libraries::OneThread until_started;
  running->environment.emplace();
}

std::vector<std::string> take_warnings() {
  return kept_warnings()->take();
}

void warn(const std::vector<std::string>& warnings) {
  for (const std::string& text : warnings) {
    const py::object type = py::module_::import("carillon.errors").attr("CarillonWarning");
    if (PyErr_WarnEx(type.ptr(), text.c_str(), 2) != 0) throw py::error_already_set();
  }
}

void set_up(py::module_& module) {
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("carillon", kept_warnings()));
  py::register_exception_translator(translate);
  py::module_::import("atexit").attr("register")(py::cpp_function(end_solver));
  module.attr("__doc__") = "The library's calls, without the Python around them.";
}

}  // namespace carillon::python
