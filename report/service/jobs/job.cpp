#include "report/service/jobs/job.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "core/error.hpp"
#include "core/files.hpp"
#include "dataset/run/status.hpp"

namespace carillon::report::service {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

namespace {

constexpr const char* document_name = "job.json";
/// Larger answers stay in the job's folder.
constexpr std::uintmax_t largest_result = 4 << 20;
constexpr std::size_t told_errors = 4000;

constexpr std::array state_names = {"queued", "running", "done", "failed", "cancelled"};

/// The end of a file, from a line's beginning; "" where there is none.
std::string last_lines(const fs::path& path) {
  std::error_code missing;
  if (!fs::is_regular_file(path, missing)) return "";
  std::string text = core::read_file(path);
  if (text.size() > told_errors) {
    text.erase(0, text.size() - told_errors);
    text.erase(0, text.find('\n') + 1);
  }
  return text;
}

}  // namespace

bool is_over(JobState state) {
  return state != JobState::queued && state != JobState::running;
}

ordered_json to_json(const Job& job) {
  ordered_json document = {{"id", job.id},
                           {"command", job.command},
                           {"arguments", job.arguments},
                           {"ranks", job.ranks},
                           {"state", state_names.at(static_cast<std::size_t>(job.state))},
                           {"created", job.created},
                           {"starts", job.starts}};
  if (!job.started.empty()) document["started"] = job.started;
  if (!job.ended.empty()) document["ended"] = job.ended;
  if (job.state == JobState::done || job.state == JobState::failed) {
    document["exit_code"] = job.exit_code;
  }
  if (!job.why.empty()) document["why"] = job.why;
  if (!job.process.is_null()) document["process"] = job.process;
  if (job.cancelled) document["cancelled"] = true;
  return document;
}

Job read_job(const fs::path& folder) {
  const fs::path path = folder / document_name;
  try {
    const json document = json::parse(core::read_file(path));
    Job job;
    job.id = document.at("id");
    job.command = document.at("command");
    job.arguments = document.at("arguments");
    job.ranks = document.at("ranks");
    const std::string state = document.at("state");
    for (std::size_t s = 0; s < state_names.size(); ++s) {
      if (state == state_names[s]) job.state = static_cast<JobState>(s);
    }
    job.created = document.at("created");
    job.started = document.value("started", "");
    job.ended = document.value("ended", "");
    job.exit_code = document.value("exit_code", 0);
    job.why = document.value("why", "");
    job.cancelled = document.value("cancelled", false);
    job.starts = document.value("starts", 0);
    job.process = document.value("process", json());
    return job;
  } catch (const json::exception& error) {
    throw core::FileError(fmt::format("{}: is no job's: {}", path.string(), error.what()),
                          "remove its folder");
  }
}

void write_job(const fs::path& folder, const Job& job) {
  core::write_text_durably(folder / document_name, to_json(job).dump(1) + "\n");
}

ordered_json describe_job(const fs::path& folder, const Job& job) {
  ordered_json document = to_json(job);
  document.erase("process");
  document.erase("cancelled");
  if (fs::exists(folder / job_output / dataset::run::status_name)) {
    try {
      document["progress"] = dataset::run::read_status(folder / job_output);
    } catch (const core::Error& error) {
      document["progress"] = {{"error", error.message()}};
    }
  }
  std::error_code missing;
  const auto size = fs::file_size(folder / job_result, missing);
  if (job.state == JobState::done && !missing && size > 0 && size <= largest_result) {
    document["result"] =
        ordered_json::parse(core::read_file(folder / job_result), nullptr, /*exceptions=*/false);
    if (document["result"].is_discarded()) document["result"] = nullptr;
  }
  if (const std::string errors = last_lines(folder / job_errors); !errors.empty()) {
    document["errors"] = errors;
  }
  return document;
}

}  // namespace carillon::report::service
