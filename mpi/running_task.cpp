#include "mpi/running_task.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/termination_blocked.hpp"
#include "core/trace.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::mpi {

namespace {

using nlohmann::json;

/// How often the thread looks whether the process was asked to stop, or is overdue.
constexpr std::chrono::milliseconds look{50};

}  // namespace

struct RunningTask::Impl {
  std::string line(const std::string& overdue) const;
  void write(std::string_view text) const;
  void note();
  void watch();

  std::filesystem::path path;
  int file = -1;
  int exit_code = 1;

  std::mutex mutex;
  std::condition_variable wake;
  bool closing = false;
  bool stopped = false;
  std::string task, stage, item, words;
  std::string overdue_line;  ///< made beforehand: later there may be no memory left
  double deadline = 0;       ///< on the monotonic clock; 0: none
  std::thread thread;
};

std::string RunningTask::Impl::line(const std::string& overdue) const {
  json record = {{"task", task}, {"stage", stage}, {"item", item}};
  if (!overdue.empty()) record["overdue"] = overdue;
  return record.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

/// A line that cannot be written is lost: the task matters more.
void RunningTask::Impl::write(std::string_view text) const {
  if (file < 0) return;
  if (pwrite(file, text.data(), text.size(), 0) < 0) return;
}

void RunningTask::Impl::note() {
  // Asked to stop: however the process ends now, the task did not end it.
  if (file >= 0 && !stopped) write(task.empty() ? "\n" : line(""));
}

void RunningTask::Impl::watch() {
  std::unique_lock lock(mutex);
  while (!wake.wait_for(lock, look, [this] { return closing; })) {
    if (task.empty()) continue;
    if (!stopped && interrupt_requested()) {
      write("\n");
      stopped = true;
    }
    if (deadline > 0 && core::monotonic_seconds() > deadline) {
      write(overdue_line);
      std::fprintf(stderr, "carillon: %s: %s; it cannot be stopped, so the run ends here\n",
                   task.c_str(), words.c_str());
      // The thread that hangs may hold any lock: no destructor, no MPI. mpirun ends the others.
      _exit(exit_code);
    }
  }
}

RunningTask::RunningTask(std::filesystem::path file, int exit_code)
    : impl_(std::make_unique<Impl>()) {
  impl_->exit_code = exit_code;
  impl_->path = std::move(file);
  if (!impl_->path.empty()) {
    std::error_code ignored;  // open() says it better
    std::filesystem::create_directories(impl_->path.parent_path(), ignored);
    impl_->file = open(impl_->path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (impl_->file < 0) {
      throw core::FileError(fmt::format("{}: cannot be written: {}", impl_->path.string(),
                                        std::generic_category().message(errno)),
                            "the output folder must be writable");
    }
  }
  const core::TerminationBlocked blocked;
  impl_->thread = std::thread([this] { impl_->watch(); });
}

RunningTask::~RunningTask() {
  {
    const std::scoped_lock lock(impl_->mutex);
    impl_->closing = true;
  }
  impl_->wake.notify_all();
  impl_->thread.join();
  if (impl_->file < 0) return;
  close(impl_->file);
  std::error_code ignored;
  std::filesystem::remove(impl_->path, ignored);
  std::filesystem::remove(impl_->path.parent_path(), ignored);  // by whoever is last
}

void RunningTask::begin(const std::string& task) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->task = task;
  impl_->stage.clear();
  impl_->item.clear();
  impl_->deadline = 0;
  impl_->note();
  if (impl_->file >= 0) fdatasync(impl_->file);
}

void RunningTask::enter(const std::string& stage, const std::string& item, double seconds,
                        const std::string& words) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->stage = stage;
  impl_->item = item;
  impl_->words = words;
  impl_->deadline = 0;
  impl_->note();
  if (seconds <= 0) return;
  impl_->overdue_line = impl_->line(words);
  impl_->deadline = core::monotonic_seconds() + seconds;
}

void RunningTask::end() {
  const std::scoped_lock lock(impl_->mutex);
  impl_->task.clear();
  impl_->deadline = 0;
  impl_->note();
}

namespace {

std::optional<BegunTask> read_begun_task(const std::filesystem::path& path) {
  try {
    // A longer line may have stood there before.
    const std::string text = core::read_file(path);
    const json record = json::parse(text.substr(0, text.find('\n')));
    return BegunTask{record.at("task"), record.at("stage"), record.at("item"),
                     record.value("overdue", ""), path.filename().string()};
  } catch (const std::exception&) {
    return {};  // no task was running, or the line is cut
  }
}

}  // namespace

std::vector<BegunTask> begun_tasks(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> paths;
  std::error_code ignored;
  for (std::filesystem::directory_iterator it(folder, ignored), end; it != end;
       it.increment(ignored)) {
    paths.push_back(it->path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<BegunTask> all;
  for (const auto& path : paths) {
    if (auto begun = read_begun_task(path)) all.push_back(std::move(*begun));
  }
  return all;
}

}  // namespace carillon::mpi
