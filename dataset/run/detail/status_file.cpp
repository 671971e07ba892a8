#include "dataset/run/detail/status_file.hpp"

#include <spdlog/spdlog.h>

#include <chrono>

#include "core/failure.hpp"
#include "core/files.hpp"
#include "core/termination_blocked.hpp"
#include "dataset/run/status.hpp"
#include "mpi/exit_code.hpp"

namespace carillon::dataset::run {

using nlohmann::ordered_json;

StatusFile::StatusFile(const std::filesystem::path& folder, ordered_json head, ordered_json now)
    : path_(folder / status_name), head_(std::move(head)), now_(std::move(now)) {
  head_["started"] = utc_date();
  end_ = {{"state", "running"}, {"exit_code", nullptr}};
  const core::TerminationBlocked blocked;
  keeper_ = std::thread([this] { keep(); });
}

StatusFile::~StatusFile() {
  end("error", mpi::exit_internal);
  keeper_.join();
}

void StatusFile::update(ordered_json now) {
  const std::scoped_lock lock(mutex_);
  now_ = std::move(now);
  news_ = true;
}

void StatusFile::end(std::string_view state, int exit_code) {
  const std::scoped_lock lock(mutex_);
  if (ended_) return;
  ended_ = true;
  end_["state"] = state;
  end_["exit_code"] = exit_code;
  write();
  woken_.notify_all();
}

void StatusFile::fail(const std::exception_ptr& error) {
  const core::Failure failure = core::describe(error);
  {
    const std::scoped_lock lock(mutex_);
    if (!ended_) end_["error"] = failure.message;
  }
  end("error", mpi::exit_code_of(failure));
}

void StatusFile::keep() {
  constexpr int seconds_between = 5;
  std::unique_lock lock(mutex_);
  for (int quiet = 0; !ended_; ++quiet) {
    if (news_ || quiet >= seconds_between) {
      write();
      news_ = false;
      quiet = 0;
    }
    woken_.wait_for(lock, std::chrono::seconds(1), [this] { return ended_; });
  }
}

void StatusFile::write() {
  ordered_json document = {{"state", end_.at("state")}, {"exit_code", end_.at("exit_code")}};
  if (end_.contains("error")) document["error"] = end_.at("error");
  document.update(head_);
  document["updated"] = utc_date();
  document.update(now_);
  constexpr auto replace = ordered_json::error_handler_t::replace;
  try {
    core::write_text_durably(path_, document.dump(2, ' ', false, replace) + "\n");
  } catch (const std::exception& error) {
    spdlog::debug("{}", error.what());
  }
}

}  // namespace carillon::dataset::run
