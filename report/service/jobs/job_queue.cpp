#include "report/service/jobs/job_queue.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/storage_error.hpp"
#include "core/text.hpp"
#include "core/trace.hpp"
#include "dataset/run/status.hpp"

namespace carillon::report::service {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

/// How often processes are looked after.
constexpr std::chrono::milliseconds look{200};
constexpr std::chrono::seconds slurm_look{5};  // its controller serves others, too
/// What was asked to stop is ended by force after so long [s]: a build ends its running tasks.
constexpr double patience = 60;
/// What ends without a word is started so often.
constexpr int max_starts = 3;

}  // namespace

fs::path JobQueue::folder_of(int id) const {
  return options_.folder / fmt::format("{:06}", id);
}

JobQueue::JobQueue(JobQueueOptions options) : options_(std::move(options)) {
  std::error_code failed;
  fs::create_directories(options_.folder, failed);
  options_.folder = fs::weakly_canonical(options_.folder);
  lock_ = ::open((options_.folder / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (lock_ < 0) {
    throw core::FileError(fmt::format("{}: cannot be written to", options_.folder.string()),
                          "--jobs names a folder for jobs");
  }
  if (flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    ::close(lock_);
    throw core::FileError(
        fmt::format("{}: another service runs its jobs", options_.folder.string()),
        "stop that, or give this one a folder of its own with --jobs");
  }
  load();
  for (int lane = 0; lane < lanes; ++lane) {
    threads_.at(static_cast<std::size_t>(lane)) =
        std::thread([this, lane] { run(static_cast<Lane>(lane)); });
  }
}

JobQueue::~JobQueue() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  woken_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  ::close(lock_);
}

void JobQueue::load() {
  for (const auto& entry : fs::directory_iterator(options_.folder)) {
    // A folder whose document was lost keeps its number.
    const auto number = core::number_in<std::int64_t>(entry.path().filename().string());
    if (number && *number < std::numeric_limits<int>::max()) {
      last_ = std::max(last_, static_cast<int>(*number));
    }
    if (!fs::is_regular_file(entry.path() / "job.json")) continue;
    try {
      const Job job = read_job(entry.path());
      jobs_[job.id] = job;
    } catch (const core::Error& error) {
      spdlog::warn("{}", error.message());
    }
  }
}

void JobQueue::save(const Job& job) {
  try {
    write_job(folder_of(job.id), job);
  } catch (const core::Error& error) {
    // A full disk: what is known goes on, and is written with the next change.
    spdlog::warn("job {}: {}", job.id, error.message());
  }
}

ordered_json JobQueue::submit(const JobRequest& request) {
  const std::lock_guard lock(mutex_);
  const auto open = std::count_if(jobs_.begin(), jobs_.end(),
                                  [](const auto& job) { return !is_over(job.second.state); });
  if (static_cast<std::size_t>(open) >= options_.longest) {
    throw core::InputError(fmt::format("{} jobs wait already", open),
                           "try again later: carillon serve --max-jobs");
  }
  Job job;
  job.id = ++last_;
  job.command = request.command;
  job.arguments = request.arguments;
  job.ranks = request.ranks;
  job.created = dataset::run::utc_date();
  const fs::path folder = folder_of(job.id);
  std::error_code made;
  if (!fs::create_directory(folder, made)) {
    throw core::StorageError(fmt::format("job {}: no folder could be made: {}", job.id,
                                         made ? made.message() : "there is one already"),
                             "see that the disk has room");
  }
  try {
    for (const auto& [name, bytes] : request.files) {
      core::write_text_durably(folder / name, bytes);
    }
    write_job(folder, job);
  } catch (const std::exception&) {
    std::error_code gone;
    fs::remove_all(folder, gone);
    throw;
  }
  jobs_[job.id] = job;
  woken_.notify_all();
  return describe_job(folder, job);
}

std::optional<ordered_json> JobQueue::find(int id) const {
  Job job;
  {
    const std::lock_guard lock(mutex_);
    const auto found = jobs_.find(id);
    if (found == jobs_.end()) return std::nullopt;
    job = found->second;
  }
  return describe_job(folder_of(id), job);
}

ordered_json JobQueue::all() const {
  const std::lock_guard lock(mutex_);
  ordered_json list = ordered_json::array();
  for (auto job = jobs_.rbegin(); job != jobs_.rend(); ++job) {
    list.push_back(to_json(job->second));
    list.back().erase("process");
    list.back().erase("cancelled");
  }
  return list;
}

std::optional<ordered_json> JobQueue::cancel(int id) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = jobs_.find(id);
    if (found == jobs_.end()) return std::nullopt;
    Job& job = found->second;
    if (is_over(job.state)) throw core::InputError(fmt::format("job {} is over", id));
    job.cancelled = true;
    if (job.process.is_null() && !starting_.contains(id)) {
      job.state = JobState::cancelled;
      job.ended = dataset::run::utc_date();
    }
    save(job);
  }
  woken_.notify_all();
  return find(id);
}

void JobQueue::run(Lane lane) {
  std::unique_lock lock(mutex_);
  for (;;) {
    look_after(lane, lock);
    if (!is_busy(lane)) {
      if (stopping_) return;
      start_next(lane, lock);
    }
    const bool slow = lane == ranks && options_.launcher == Launcher::slurm && !stopping_;
    woken_.wait_for(lock, slow ? std::chrono::milliseconds(slurm_look) : look);
  }
}

/// What is asked of the system or of Slurm, which may take its time: others ask the queue
/// meanwhile.
/// @return why it could not be done; "": it was
std::string JobQueue::outside(std::unique_lock<std::mutex>& lock, int id,
                              const std::function<void()>& action) {
  lock.unlock();
  std::string problem;
  try {
    action();
  } catch (const std::exception& error) {
    problem = error.what();
    spdlog::warn("job {}: {}", id, problem);
  }
  lock.lock();
  return problem;
}

/// Settles those whose process has ended, and stops what is to be stopped.
void JobQueue::look_after(Lane lane, std::unique_lock<std::mutex>& lock) {
  std::vector<int> started;
  for (const auto& [id, job] : jobs_) {
    if (lane_of(job) == lane && !job.process.is_null()) started.push_back(id);
  }
  for (const int id : started) {
    Job& job = jobs_.at(id);  // jobs stay where they are, and their processes are this thread's
    JobProcess process;
    // Of what cannot be looked after it is taken that it runs.
    outside(lock, id, [&] { process = find_process(folder_of(id), job.process); });
    if (!process.runs) {
      settle(job, process);
      continue;
    }
    const JobState state = process.waits ? JobState::queued : JobState::running;
    if (state != job.state) {
      job.state = state;
      save(job);
    }
    if (!job.cancelled && !(stopping_ && !job.process.contains("slurm"))) continue;
    const double now = core::monotonic_seconds();
    const auto [asked, first] = asked_.try_emplace(id, now);
    const bool late = now - asked->second > patience;
    if (first || late) outside(lock, id, [&] { stop_process(job.process, late); });
  }
}

/// Something of this lane runs on this machine: what Slurm has is Slurm's to order.
bool JobQueue::is_busy(Lane lane) const {
  return std::any_of(jobs_.begin(), jobs_.end(), [&](const auto& entry) {
    const Job& job = entry.second;
    return lane_of(job) == lane && !job.process.is_null() && !job.process.contains("slurm");
  });
}

/// The one that has waited longest; all of them where Slurm orders them.
void JobQueue::start_next(Lane lane, std::unique_lock<std::mutex>& lock) {
  std::vector<int> waiting;
  for (const auto& [id, job] : jobs_) {
    if (lane_of(job) == lane && job.state == JobState::queued && job.process.is_null()) {
      waiting.push_back(id);
    }
  }
  for (const int id : waiting) {
    if (stopping_) return;
    Job& job = jobs_.at(id);
    if (job.state != JobState::queued) continue;  // cancelled meanwhile
    start(job, lock);
    if (!job.process.is_null() && !job.process.contains("slurm")) return;
  }
}

void JobQueue::start(Job& job, std::unique_lock<std::mutex>& lock) {
  job.started = dataset::run::utc_date();
  ++job.starts;
  starting_.insert(job.id);
  nlohmann::json process;
  const std::string problem = outside(lock, job.id, [&, copy = job] {
    process = start_process(folder_of(copy.id), copy, options_.launcher, options_.program);
  });
  starting_.erase(job.id);
  job.process = std::move(process);
  if (!job.process.is_null()) {
    job.state = job.process.contains("slurm") ? JobState::queued : JobState::running;
  } else if (job.cancelled) {
    job.state = JobState::cancelled;
  } else if (job.starts >= max_starts) {
    job.state = JobState::failed;
    job.exit_code = -1;
    job.why = problem;
  }  // else Slurm's controller may rest, or the system be short of something: it waits
  if (is_over(job.state)) job.ended = dataset::run::utc_date();
  save(job);
}

void JobQueue::settle(Job& job, const JobProcess& process) {
  const bool was_stopped = stopping_ && asked_.contains(job.id);
  job.process = nullptr;
  asked_.erase(job.id);
  const bool done = process.exit_code == 0;
  if (job.cancelled && !done) {
    job.state = JobState::cancelled;
  } else if (!done && (was_stopped || (!process.exit_code && job.starts < max_starts))) {
    job.state = JobState::queued;
    if (was_stopped) --job.starts;  // no fault of its own
  } else {
    job.state = done ? JobState::done : JobState::failed;
    job.exit_code = process.exit_code.value_or(-1);
    if (!process.exit_code) job.why = "its process ended without a word, as one that is killed";
  }
  if (is_over(job.state)) job.ended = dataset::run::utc_date();
  save(job);
}

}  // namespace carillon::report::service
