#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/time_limit.hpp"

namespace carillon::python {

namespace py = pybind11;

/// Whether a call of Python's still waits; shared with the thread that works for it.
class Waiting {
 public:
  bool given_up() const { return given_up_->load(); }
  void give_up() const { given_up_->store(true); }
  /// For work that looks at it now and then.
  core::TimeLimit limit(const std::string& work) const;

 private:
  std::shared_ptr<std::atomic<bool>> given_up_ = std::make_shared<std::atomic<bool>>(false);
};

/// Work of the library runs in one thread at a time: PETSc has one state.
std::timed_mutex& turn();

/// Waits for the turn without Python's lock; Ctrl-C ends the waiting.
/// @throws py::error_already_set  KeyboardInterrupt
std::unique_lock<std::timed_mutex> wait_for_turn();

/// MPI and PETSc, started when modes or a plan are first asked for and ended when Python ends. MPI
/// that runs already (mpi4py's) is used as it is. For the thread that calls, before work begins.
void start_solver();

/// What the library has warned of since the last call.
std::vector<std::string> take_warnings();
/// As Python's warnings.
/// @throws py::error_already_set  Python takes warnings for errors
void warn(const std::vector<std::string>& warnings);

/// Translates the library's errors, takes its warnings, and ends the solver with Python.
void set_up(py::module_& module);

/// How long is waited before signals are looked at.
constexpr std::chrono::milliseconds look(50);

/// Lets `work` run without Python's lock in a thread of its own and waits for it. Ctrl-C ends the
/// waiting at once; work that looks at its Waiting then ends at its next step, and what does not
/// look ends when it is done. The next call's work begins after it.
/// @param work  takes a Waiting and owns what it uses: it may outlive the call
template <class Work>
auto interruptible(Work work) {
  using Result = decltype(work(std::declval<Waiting>()));
  struct Call {
    std::mutex mutex;
    std::condition_variable ended;
    bool done = false;
    std::optional<Result> result{};
    std::exception_ptr error{};
    std::vector<std::string> warnings{};
  };
  const auto call = std::make_shared<Call>();
  const Waiting waiting;
  std::thread([call, waiting, work = std::move(work)]() mutable {
    std::optional<Result> result;
    std::exception_ptr error;
    std::vector<std::string> warnings;
    {
      const std::scoped_lock own_turn(turn());
      try {
        if (!waiting.given_up()) result.emplace(work(waiting));
      } catch (...) {
        error = std::current_exception();
      }
      warnings = take_warnings();
    }
    const std::scoped_lock lock(call->mutex);
    call->result = std::move(result);
    call->error = error;
    call->warnings = std::move(warnings);
    call->done = true;
    call->ended.notify_all();
  }).detach();
  for (bool done = false; !done;) {
    {
      const py::gil_scoped_release unlocked;
      std::unique_lock lock(call->mutex);
      done = call->ended.wait_for(lock, look, [&] { return call->done; });
    }
    if (PyErr_CheckSignals() != 0) {
      waiting.give_up();
      throw py::error_already_set();
    }
  }
  if (call->error) {
    try {
      warn(call->warnings);
    } catch (const py::error_already_set&) {
      // A warning that Python takes for an error is not what went wrong here.
    }
    std::rethrow_exception(call->error);
  }
  warn(call->warnings);
  return std::move(*call->result);
}

/// An array that takes over its values.
template <class T>
py::array_t<T> array_of(std::vector<T> values, const std::vector<py::ssize_t>& shape) {
  auto* kept = new std::vector<T>(std::move(values));
  const py::capsule owner(kept, [](void* all) { delete static_cast<std::vector<T>*>(all); });
  return py::array_t<T>(shape, kept->data(), owner);
}

template <class T>
py::array_t<T> array_of(std::vector<T> values) {
  const auto size = static_cast<py::ssize_t>(values.size());
  return array_of(std::move(values), {size});
}

/// Each adds its part to the module.
void bind_objects(py::module_& module);
void bind_sounds(py::module_& module);
void bind_datasets(py::module_& module);
void bind_learning(py::module_& module);

}  // namespace carillon::python
