#include "dataset/run/detail/last_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

#include "mpi/context.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

int Summary::exit_code() const {
  return interrupted ? mpi::exit_interrupted : failed > 0 ? mpi::exit_failures : mpi::exit_done;
}

void print(const Summary& summary, bool as_json) {
  if (as_json) {
    fmt::print("{}\n", json{{"output", summary.output},
                            {"shapes", summary.shapes},
                            {"samples", summary.samples},
                            {"tasks_run", summary.tasks_run},
                            {"failed_tasks", summary.failed},
                            {"missed_pitch_targets", summary.missed},
                            {"interrupted", summary.interrupted}}
                           .dump(2));
    return;
  }
  if (summary.tasks_run == 0 && !summary.interrupted) {
    fmt::print("nothing to do: {} {} {} samples of {} shapes\n", summary.output,
               summary.failed > 0 ? "holds" : "is complete with", summary.samples, summary.shapes);
  } else {
    fmt::print("{}: {} samples of {} shapes, {} tasks run\n", summary.output, summary.samples,
               summary.shapes, summary.tasks_run);
  }
  if (summary.interrupted) fmt::print("interrupted: run the same command to go on\n");
  if (!summary.missed.empty()) {
    fmt::print("{} of {} shapes missed the pitch target: dataset.json says by how much\n",
               summary.missed.size(), summary.shapes);
  }
  if (summary.failed > 0) {
    fmt::print("{} failed tasks: {}/failures.json says why\n", summary.failed, summary.output);
  }
}

void LastWords::count(const std::function<void()>& record) {
  const std::scoped_lock lock(mutex_);
  record();
  ++tasks_run_;
}

void LastWords::keep() {
  const std::scoped_lock lock(mutex_);
  kept_ = true;
}

mpi::InterruptGuard::Leaving LastWords::leaving() {
  mpi::InterruptGuard::Leaving leaving;
  if (index_ != nullptr) leaving.last_words = [this] { say(); };
  return leaving;
}

void LastWords::say() {
  // Most of the index while the program may still get out by itself, the rest and the summary when
  // that has become unlikely.
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds hope(200), to_spare(50);
  const auto begin = Clock::now();
  index_->write_now();
  // The second writing takes as long as the first, and must end within the grace as well.
  const Clock::duration latest =
      mpi::InterruptGuard::Leaving{}.grace - to_spare - (Clock::now() - begin);
  while (Clock::now() - begin < std::min<Clock::duration>(hope, latest)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const std::scoped_lock lock(mutex_);
    if (kept_) return;
  }
  mutex_.lock();
  if (kept_) {
    mutex_.unlock();
    return;
  }
  // Never unlocked: the process ends within the grace.
  const std::vector<Results> results = index_->write_now();
  if (tell_) tell_(results, tasks_run_);
  std::fflush(stdout);
}

}  // namespace carillon::dataset::run
