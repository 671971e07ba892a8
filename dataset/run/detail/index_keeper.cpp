#include "dataset/run/detail/index_keeper.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

#include "core/data_limit.hpp"
#include "core/termination_blocked.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

IndexKeeper::IndexKeeper(std::vector<KeptIndex> builds)
    : builds_(std::move(builds)), results_(builds_.size()), begin_(core::monotonic_seconds()) {
  for (std::size_t b = 0; b < builds_.size(); ++b) {
    joined_.emplace_back(builds_[b].folders->output);
    behind_.insert(b);
  }
  const core::TerminationBlocked blocked;
  thread_ = std::thread([this] { run(); });
}

IndexKeeper::~IndexKeeper() {
  end();
}

void IndexKeeper::end() {
  {
    const std::scoped_lock lock(news_mutex_);
    ending_ = true;
  }
  woken_.notify_all();
  if (thread_.joinable()) thread_.join();
  const std::scoped_lock writing(write_mutex_);
  ended_ = true;
}

void IndexKeeper::add(std::size_t build, const json& entry) {
  const std::scoped_lock lock(news_mutex_);
  news_.push_back({build, entry});
}

/// There is time for another writing.
bool IndexKeeper::due() const {
  const double elapsed = core::monotonic_seconds() - begin_;
  return spent_ + last_ <= grace + fraction * elapsed;
}

void IndexKeeper::run() try {
  // What is done already is written at once.
  for (std::chrono::milliseconds pause(0);; pause = std::chrono::milliseconds(100)) {
    {
      std::unique_lock lock(news_mutex_);
      if (woken_.wait_for(lock, pause, [this] { return ending_; })) return;
    }
    // The host's own task may be one that is bounded in memory.
    const core::DataLimitRests rests;
    const std::scoped_lock writing(write_mutex_);
    take_news();
    read_files();
    while (!behind_.empty() && due() && !ended_ && !is_ending()) write_next();
  }
} catch (const std::exception& error) {
  // The builds go on, and write it at their end.
  spdlog::warn("the index is not brought up to date any more: {}", error.what());
}

bool IndexKeeper::is_ending() const {
  const std::scoped_lock lock(news_mutex_);
  return ending_;
}

void IndexKeeper::take_news() {
  std::vector<News> news;
  {
    const std::scoped_lock lock(news_mutex_);
    news = std::exchange(news_, {});
  }
  for (auto& [build, entry] : news) {
    const std::string task = entry.at("task");
    for (const json& file : entry.value("files", json::array())) {
      const std::string path = file.at("path");
      if (!path.ends_with(".h5")) continue;
      joined_[build].forget(path);  // a shard that grew is another file now
      unread_.emplace_back(build, path);
    }
    builds_[build].finished[task] = std::move(entry);
    behind_.insert(build);
  }
}

void IndexKeeper::read_files() {
  const double start = core::monotonic_seconds();
  while (!unread_.empty() && !ended_ && !is_ending()) {
    const auto [build, file] = unread_.back();
    unread_.pop_back();
    try {
      joined_[build].of(file);
    } catch (const std::exception&) {
      // The writing reads it again, and says so.
    }
  }
  spent_ = spent_ + (core::monotonic_seconds() - start);
}

void IndexKeeper::write(std::size_t build) {
  const KeptIndex& kept = builds_[build];
  results_[build] = write_results(*kept.build, *kept.folders, kept.finished, joined_[build]);
}

void IndexKeeper::write_next() {
  const std::size_t b = *behind_.begin();
  behind_.erase(behind_.begin());
  const double start = core::monotonic_seconds();
  try {
    write(b);
    failed_.erase(b);
  } catch (const std::exception& error) {
    failed_.insert(b);
    if (!told_) spdlog::warn("the index could not be brought up to date: {}", error.what());
    told_ = true;
  }
  last_ = core::monotonic_seconds() - start;
  spent_ = spent_ + last_;
  ++calls_;
}

std::vector<Results> IndexKeeper::finish() {
  end();
  const std::scoped_lock writing(write_mutex_);
  take_news();
  behind_.merge(failed_);
  for (const std::size_t b : behind_) write(b);
  behind_.clear();
  return results_;
}

std::vector<Results> IndexKeeper::write_now() {
  const core::DataLimitRests rests;
  const std::scoped_lock writing(write_mutex_);
  take_news();
  while (!behind_.empty() && !ended_) write_next();
  return results_;
}

}  // namespace carillon::dataset::run
