#include "dataset/run/status.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <iomanip>
#include <limits>
#include <sstream>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/progress.hpp"
#include "core/what_is.hpp"
#include "dataset/run/detail/attempts.hpp"
#include "mpi/folder_lock.hpp"
#include "mpi/running_task.hpp"

namespace carillon::dataset::run {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

/// How long a build that runs may say nothing [s]: it writes every five seconds.
constexpr double silence_s = 20;

/// Seconds since a date of utc_date(); infinite where it is none.
double age(const std::string& date) {
  std::tm then{};
  std::istringstream text(date);
  text >> std::get_time(&then, "%Y-%m-%dT%H:%M:%SZ");
  if (text.fail()) return std::numeric_limits<double>::infinity();
  return std::difftime(std::time(nullptr), timegm(&then));
}

core::InputError no_status(const fs::path& folder) {
  const core::WhatIs what = core::what_is(folder);
  const std::string sweep =
      (fs::absolute(folder).lexically_normal() / "x").parent_path().parent_path().string();
  const bool variant = fs::exists(fs::path(sweep) / "sweep.json");
  return core::InputError(
      fmt::format("{}: {}", folder.string(),
                  what.name == "missing" ? "there is no such folder"
                                         : fmt::format("there is no {} in it", status_name)),
      variant
          ? fmt::format("a variant of a sweep is built with the others: carillon status {}", sweep)
          : "name the folder that `carillon build` makes");
}

std::string duration(const ordered_json& seconds) {
  return seconds.is_number() ? core::human_duration(std::ceil(seconds.get<double>()))
                             : "unknown time";
}

std::string counted(const ordered_json& count) {
  std::string text = fmt::format("{} of {}", count.at("done").get<std::int64_t>(),
                                 count.at("all").get<std::int64_t>());
  if (const auto failed = count.at("failed").get<std::int64_t>(); failed > 0)
    text += fmt::format(", {} failed", failed);
  return text;
}

std::string rate(const ordered_json& status) {
  const ordered_json& rate = status.at("samples_per_s");
  return rate.is_number() ? fmt::format("{:.3g} samples/s", rate.get<double>()) : "";
}

/// "running, 43 %, 1 min 20 s left".
std::string state_text(const ordered_json& status) {
  const std::string state = status.at("state");
  const std::string after = " after " + duration(status.at("elapsed_s"));
  if (state == "running") {
    std::string text = "running";
    if (status.at("fraction").is_number())
      text += fmt::format(", {:.0f} %", std::floor(100 * status.at("fraction").get<double>()));
    if (status.at("remaining_s").is_number())
      text += ", " + duration(status.at("remaining_s")) + " left";
    return text;
  }
  if (state == "done") {
    return status.at("tasks").at("failed") > 0 ? "done" + after + ", but for what failed"
                                               : "done" + after;
  }
  if (state == "interrupted") return "interrupted" + after + ": run the same command to go on";
  if (state == "lost") {
    return fmt::format(
        "no word since {}: killed, or its node is gone; run the same command to go on",
        status.at("updated").get<std::string>());
  }
  return "ended by an error" + after +
         (status.contains("error") ? ": " + status.at("error").get<std::string>() : "");
}

/// Its kinds of values are those that status_text() wants.
void require_whole(const ordered_json& status) {
  for (const char* text : {"state", "name", "host", "started", "updated"})
    static_cast<void>(status.at(text).get<std::string>());
  for (const char* number : {"elapsed_s", "bytes", "ranks"})
    static_cast<void>(status.at(number).get<double>());
  for (const char* either : {"exit_code", "fraction", "remaining_s", "samples_per_s"})
    static_cast<void>(status.at(either));
  for (const char* count : {"samples", "objects", "tasks"}) {
    for (const char* part : {"all", "done", "failed"})
      static_cast<void>(status.at(count).at(part).get<std::int64_t>());
  }
}

}  // namespace

ordered_json read_status(const fs::path& folder) {
  const fs::path file = folder / status_name;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) throw no_status(folder);
  ordered_json status;
  try {
    status = core::read_ordered_json(file);
    require_whole(status);
    if (status.at("state") != "running") return status;
    if (age(status.at("updated")) > silence_s && !mpi::is_locked(folder)) {
      status["state"] = "lost";
      return status;
    }
  } catch (const nlohmann::json::exception& problem) {
    throw core::InputError(fmt::format("{}: {}", file.string(), problem.what()),
                           "the next build of this folder writes it anew");
  }
  status["running"] = ordered_json::array();
  for (const mpi::BegunTask& task : mpi::begun_tasks(running_file(folder, 0).parent_path()))
    status["running"].push_back({{"rank", rank_of_running_file(task.file)},
                                 {"task", task.task},
                                 {"stage", task.stage},
                                 {"item", task.item}});
  return status;
}

std::string status_text(const ordered_json& status) {
  std::string text =
      fmt::format("{}: {}\n", status.at("name").get<std::string>(), state_text(status));
  const auto line = [&](const char* name, const std::string& value) {
    text += fmt::format("  {:<10} {}\n", name, value);
  };
  const std::string speed = rate(status);
  line("samples", counted(status.at("samples")) + (speed.empty() ? "" : ", " + speed));
  line("objects", counted(status.at("objects")));
  line("tasks", counted(status.at("tasks")));
  line("on disk", core::human_bytes(status.at("bytes").get<double>()));
  for (const ordered_json& task : status.value("running", ordered_json::array())) {
    const std::string stage = task.at("stage");
    line("now", task.at("task").get<std::string>() + (stage.empty() ? "" : ", " + stage));
  }
  line("begun", fmt::format("{} on {}, {} rank{}", status.at("started").get<std::string>(),
                            status.at("host").get<std::string>(), status.at("ranks").get<int>(),
                            status.at("ranks") == 1 ? "" : "s"));
  return text;
}

std::string status_line(const ordered_json& status) {
  const std::string speed = rate(status);
  return fmt::format("{}: {}  {} samples{}  {} objects  {}", status.at("name").get<std::string>(),
                     state_text(status), counted(status.at("samples")),
                     speed.empty() ? "" : "  " + speed, counted(status.at("objects")),
                     core::human_bytes(status.at("bytes").get<double>()));
}

std::string utc_date() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

}  // namespace carillon::dataset::run
