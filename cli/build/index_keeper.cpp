#include "cli/build/index_keeper.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

namespace carillon::cli {

using nlohmann::json;

IndexKeeper::IndexKeeper(const LoadedBuild& build, const BuildFolders& folders,
                         std::map<std::string, json> finished)
    : build_(build),
      folders_(folders),
      finished_(std::move(finished)),
      begin_(core::monotonic_seconds()) {
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

void IndexKeeper::add(const json& entry) {
  const std::scoped_lock lock(news_mutex_);
  news_.push_back(entry);
}

/// There is something new, and time for it.
bool IndexKeeper::due() const {
  if (news_.empty()) return false;
  const double elapsed = core::monotonic_seconds() - begin_;
  return spent_ + last_ <= grace + share * elapsed;
}

void IndexKeeper::run() {
  write_now();
  for (;;) {
    {
      std::unique_lock lock(news_mutex_);
      if (woken_.wait_for(lock, std::chrono::milliseconds(100), [this] { return ending_; })) return;
      if (!due()) continue;
    }
    write_now();
  }
}

Results IndexKeeper::write_now() {
  const std::scoped_lock writing(write_mutex_);
  if (ended_) return results_;
  std::vector<json> news;
  {
    const std::scoped_lock lock(news_mutex_);
    news = std::exchange(news_, {});
  }
  if (news.empty() && written_) return results_;
  for (json& entry : news) {
    const std::string task = entry.at("task");
    finished_[task] = std::move(entry);
  }
  const double start = core::monotonic_seconds();
  try {
    results_ = write_results(build_, folders_, finished_);
    written_ = true;
  } catch (const std::exception& error) {
    if (!told_) spdlog::warn("the index could not be brought up to date: {}", error.what());
    told_ = true;
  }
  last_ = core::monotonic_seconds() - start;
  spent_ = spent_ + last_;
  ++calls_;
  return results_;
}

}  // namespace carillon::cli
