#include "mpi/witness.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/termination_blocked.hpp"
#include "core/trace.hpp"
#include "mpi/crash_note.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::mpi {

namespace {

using nlohmann::json;

// Places in the file: each kind of news has its own, so that no writer waits for another. A crash
// has the last word but one.
constexpr off_t task_at = 0, resident_at = 4096, stopped_at = 4160, crashed_at = 4224,
                overdue_at = 4288, file_size = 4800;
/// How often the thread looks, and how often it notes the memory.
constexpr std::chrono::milliseconds look{50};
constexpr int looks_per_note = 10;

std::string unique_name(const Host& host) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return fmt::format("{}:{}:{}", host.name, getpid(),
                     std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

/// The line at a place, without its newline.
std::string line_at(std::string_view text, off_t place) {
  const auto begin = static_cast<std::size_t>(place);
  if (begin >= text.size()) return {};
  const std::string_view rest = text.substr(begin);
  return std::string(rest.substr(0, rest.find_first_of(std::string_view("\n\0", 2))));
}

}  // namespace

struct Witness::Impl {
  void write(off_t place, std::string_view line);
  void write_task();
  void note_memory();
  void watch();

  std::filesystem::path path;
  int file = -1;
  int ranks = 1;
  int exit_code = 1;
  std::string process;
  std::optional<CrashNote> crash_note;

  std::mutex mutex;
  std::condition_variable wake;
  bool closing = false;
  std::string task, stage, item;
  Host host;
  double deadline = 0;  ///< on the monotonic clock; 0: none
  std::string words;
  bool stop_noted = false;
  std::thread thread;
};

/// News that cannot be written are lost: the task matters more. Allocates nothing, as the task may
/// have taken all there is.
void Witness::Impl::write(off_t place, std::string_view line) {
  if (file < 0) return;
  char newline = '\n';
  const std::array<iovec, 2> parts{{{const_cast<char*>(line.data()), line.size()}, {&newline, 1}}};
  if (pwritev(file, parts.data(), parts.size(), place) < 0) return;
}

void Witness::Impl::write_task() {
  if (file < 0) return;
  json record = json::object();
  if (!task.empty()) {
    record = to_json(host);
    record.update(
        {{"process", process}, {"ranks", ranks}, {"task", task}, {"stage", stage}, {"item", item}});
  }
  std::string line = record.dump(-1, ' ', false, json::error_handler_t::replace);
  if (line.size() >= static_cast<std::size_t>(resident_at)) {
    record["item"] = "";  // names without end: the task's own has to do
    line = record.dump(-1, ' ', false, json::error_handler_t::replace);
  }
  if (line.size() < static_cast<std::size_t>(resident_at)) write(task_at, line);
}

void Witness::Impl::note_memory() {
  std::array<char, 24> text{};
  const auto end = std::to_chars(text.begin(), text.end(), process_memory().resident).ptr;
  write(resident_at, {text.data(), static_cast<std::size_t>(end - text.data())});
}

void Witness::Impl::watch() {
  std::unique_lock lock(mutex);
  for (int looks = 0; !wake.wait_for(lock, look, [this] { return closing; }); ++looks) {
    if (task.empty()) continue;
    if (!stop_noted && interrupt_requested()) {
      write(stopped_at, "stopped");
      stop_noted = true;
    }
    if (looks % looks_per_note == 0) note_memory();
    if (deadline > 0 && core::monotonic_seconds() > deadline) {
      write(overdue_at, words);
      std::fprintf(stderr, "carillon: %s: %s; it cannot be stopped, so the run ends here\n",
                   task.c_str(), words.c_str());
      // The thread that hangs may hold any lock: no destructor, no MPI. mpirun ends the others.
      _exit(exit_code);
    }
  }
}

Witness::Witness(std::filesystem::path file, int ranks, int exit_code)
    : impl_(std::make_unique<Impl>()) {
  impl_->ranks = ranks;
  impl_->exit_code = exit_code;
  impl_->path = std::move(file);
  if (!impl_->path.empty()) {
    std::error_code ignored;  // open() says it better
    std::filesystem::create_directories(impl_->path.parent_path(), ignored);
    impl_->file = open(impl_->path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (impl_->file < 0 || ftruncate(impl_->file, file_size) != 0) {
      const int error = errno;
      if (impl_->file >= 0) close(impl_->file);
      throw core::FileError(fmt::format("{}: cannot be written: {}", impl_->path.string(),
                                        std::generic_category().message(error)),
                            "the output folder must be writable");
    }
    impl_->process = unique_name(this_host());
    impl_->crash_note.emplace(impl_->file, crashed_at);
  }
  const core::TerminationBlocked blocked;
  impl_->thread = std::thread([this] { impl_->watch(); });
}

Witness::~Witness() {
  {
    const std::scoped_lock lock(impl_->mutex);
    impl_->closing = true;
  }
  impl_->wake.notify_all();
  impl_->thread.join();
  impl_->crash_note.reset();
  if (impl_->file < 0) return;
  close(impl_->file);
  std::error_code ignored;
  std::filesystem::remove(impl_->path, ignored);
  std::filesystem::remove(impl_->path.parent_path(), ignored);  // by whoever is last
}

void Witness::begin(const std::string& task) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->task = task;
  impl_->stage.clear();
  impl_->item.clear();
  impl_->deadline = 0;
  if (impl_->file >= 0) impl_->host = this_host();
  impl_->write_task();
}

void Witness::enter(const std::string& stage, const std::string& item, double seconds,
                    const std::string& words) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->stage = stage;
  impl_->item = item;
  impl_->deadline = seconds > 0 ? core::monotonic_seconds() + seconds : 0;
  impl_->words = words;
  impl_->write_task();
}

void Witness::end() {
  begin("");
}

namespace {

std::optional<Testimony> read_testimony(const std::filesystem::path& path) {
  try {
    const std::string text = core::read_file(path);
    const json record = json::parse(line_at(text, task_at));
    if (!record.contains("task")) return {};
    Testimony told;
    told.process = record.at("process");
    told.ranks = record.at("ranks");
    told.task = record.at("task");
    told.stage = record.at("stage");
    told.item = record.at("item");
    told.host = host_from_json(record);
    const std::string resident = line_at(text, resident_at);
    if (!resident.empty()) told.resident = std::stoll(resident);
    const std::string overdue = line_at(text, overdue_at), crashed = line_at(text, crashed_at);
    if (!overdue.empty()) {
      told.end = Testimony::End::overdue;
      told.words = overdue;
    } else if (!crashed.empty()) {
      told.end = Testimony::End::crashed;
      told.words = crashed;
    } else if (!line_at(text, stopped_at).empty()) {
      told.end = Testimony::End::stopped;
    }
    return told;
  } catch (const std::exception&) {
    return {};  // cut short, or not one of ours
  }
}

}  // namespace

std::vector<Testimony> read_testimonies(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> paths;
  std::error_code ignored;
  for (std::filesystem::directory_iterator it(folder, ignored), end; it != end;
       it.increment(ignored)) {
    paths.push_back(it->path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Testimony> all;
  for (const auto& path : paths) {
    if (auto told = read_testimony(path)) all.push_back(std::move(*told));
  }
  return all;
}

}  // namespace carillon::mpi
