#include "dataset/plan/task_times.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/json.hpp"
#include "core/progress.hpp"
#include "mpi/comm.hpp"

namespace carillon::dataset::plan {

using nlohmann::json;

json to_json(const TaskRow& row) {
  return {{"run", row.run},
          {"kind", row.kind},
          {"estimate_s", row.estimate},
          {"seconds", row.times.seconds},
          {"cpu_s", row.times.cpu},
          {"queued_s", row.times.queued},
          {"rank", row.times.rank},
          {"width", row.times.width},
          {"start_s", row.times.start}};
}

TaskRow task_row(const std::string& task, const json& times) {
  TaskRow row;
  row.task = task;
  row.kind = times.value("kind", task.substr(0, task.find('/')));
  row.run = times.value("run", 0);
  row.estimate = times.value("estimate_s", 0.0);
  row.times = {times.value("start_s", 0.0),  times.at("seconds"),    times.value("cpu_s", 0.0),
               times.value("queued_s", 0.0), times.value("rank", 0), times.value("width", 1)};
  return row;
}

json to_json(const std::vector<TaskRow>& rows) {
  json list = json::array();
  for (const TaskRow& row : rows) {
    list.push_back(to_json(row));
    list.back()["task"] = row.task;
  }
  return list;
}

std::vector<TaskRow> task_rows(const json& trace) {
  std::vector<TaskRow> rows;
  for (const json& row : trace.value("tasks", json::array())) {
    rows.push_back(task_row(row.at("task"), row));
  }
  return rows;
}

int next_run(const std::vector<json>& journal) {
  int last = 0;
  for (const json& entry : journal) {
    if (entry.contains("times")) last = std::max(last, task_row("", entry.at("times")).run);
  }
  return last + 1;
}

std::vector<TaskRow> task_rows(const std::map<std::string, json>& finished) {
  std::vector<TaskRow> rows;
  for (const auto& [task, entry] : finished) {
    if (entry.contains("times")) rows.push_back(task_row(task, entry.at("times")));
  }
  std::sort(rows.begin(), rows.end(), [](const TaskRow& a, const TaskRow& b) {
    return std::pair(a.run, a.times.start) < std::pair(b.run, b.times.start);
  });
  return rows;
}

namespace {

/// When the last task of a run began [s].
double last_start(const std::vector<TaskRow>& rows, int run) {
  double last = 0;
  for (const TaskRow& row : rows) {
    if (row.run == run) last = std::max(last, row.times.start);
  }
  return last;
}

}  // namespace

double busy_fraction(const std::vector<TaskRow>& rows, int run,
                     const std::vector<mpi::RankTimes>& ranks) {
  const double last = last_start(rows, run);
  double cpu = 0, in_tasks = 0, queued = 0;
  for (const mpi::RankTimes& rank : ranks) queued += rank.queued;
  for (const TaskRow& row : rows) {
    const mpi::TaskTimes& times = row.times;
    if (row.run != run || times.seconds <= 0) continue;
    const double until_last = std::min(times.seconds, last - times.start);
    cpu += times.cpu * until_last / times.seconds;
    in_tasks += until_last * times.width;
    // What a group's ranks neither compute nor queue for, they wait for each other.
    if (times.width > 1) {
      const double waiting = times.seconds * times.width - times.cpu - times.queued;
      in_tasks -= std::max(0.0, waiting) * until_last / times.seconds;
    }
    queued -= times.queued;
  }
  const double between = static_cast<double>(ranks.size()) * last - in_tasks;
  const double idle = std::max(0.0, between - std::max(0.0, queued));
  return cpu + idle > 0 ? cpu / (cpu + idle) : 1;
}

double computing_fraction(const std::vector<TaskRow>& rows, int run,
                          const std::vector<mpi::RankTimes>& ranks) {
  const double last = last_start(rows, run);
  double cpu = 0, queued = 0;
  for (const mpi::RankTimes& rank : ranks) queued += rank.queued;
  for (const auto& [task, kind, of_run, estimate, times] : rows) {
    if (of_run != run || times.seconds <= 0) continue;
    const double part = std::min(1.0, (last - times.start) / times.seconds);
    cpu += times.cpu * part;
    // Of what other programs took, the part after the last task's beginning.
    queued -= times.queued * (1 - part);
  }
  const double available = static_cast<double>(ranks.size()) * last - std::max(0.0, queued);
  return available > 0 ? std::min(1.0, cpu / available) : 1;
}

namespace {

json to_json(const mpi::EstimateError& error) {
  return {{"median", error.median}, {"spread", error.spread}};
}

mpi::EstimateError estimate_error(const json& error) {
  return {error.at("median"), error.at("spread")};
}

}  // namespace

json to_json(const std::vector<mpi::RankTimes>& ranks) {
  json list = json::array();
  for (const mpi::RankTimes& rank : ranks) {
    list.push_back({{"busy_s", rank.busy},
                    {"idle_s", rank.idle},
                    {"cpu_s", rank.cpu},
                    {"queued_s", rank.queued},
                    {"peak_memory_bytes", rank.peak_memory}});
  }
  return list;
}

json to_json(const RunRecord& run) {
  json out = {{"run", run.run},
              {"ranks", to_json(run.ranks)},
              {"estimates", json::object()},
              {"busy_fraction", run.busy_fraction}};
  if (run.computing_fraction) out["computing_fraction"] = *run.computing_fraction;
  if (!run.made.is_null()) out["made"] = run.made;
  for (const auto& [kind, report] : run.estimates) {
    out["estimates"][kind] = {{"tasks", report.tasks},
                              {"before", to_json(report.before)},
                              {"after", to_json(report.after)}};
  }
  return out;
}

namespace {

RunRecord run_record(const json& from) {
  RunRecord run;
  run.run = from.at("run");
  for (const json& rank : from.at("ranks")) {
    run.ranks.push_back({rank.at("busy_s"), rank.at("idle_s"), rank.value("cpu_s", 0.0),
                         rank.value("queued_s", 0.0), rank.value("peak_memory_bytes", 0.0)});
  }
  run.busy_fraction = from.at("busy_fraction");
  // Runs of earlier versions do not tell.
  if (from.contains("computing_fraction")) run.computing_fraction = from.at("computing_fraction");
  for (const auto& [kind, report] : from.at("estimates").items()) {
    run.estimates[kind] = {report.at("tasks"), estimate_error(report.at("before")),
                           estimate_error(report.at("after"))};
  }
  run.made = from.value("made", json());
  return run;
}

}  // namespace

std::optional<RunRecord> last_run(const std::filesystem::path& trace) {
  try {
    const json runs = core::read_json(trace).value("runs", json::array());
    if (!runs.empty()) return run_record(runs.back());
  } catch (const std::exception&) {
    // Only times are lost.
  }
  return {};
}

namespace {

/// What each rank was idle, or, of many, the least, the middle and the most idle one.
std::string idle_text(const std::vector<mpi::RankTimes>& ranks) {
  constexpr std::size_t all_named = 8;
  std::vector<std::pair<double, std::size_t>> idle;
  for (std::size_t r = 0; r < ranks.size(); ++r) idle.emplace_back(ranks[r].idle, r);
  if (idle.empty()) return "";
  std::vector<std::string> parts;
  const auto name = [&](const char* what, const std::pair<double, std::size_t>& one) {
    parts.push_back(fmt::format("{}rank {} {}", what, one.second, core::human_duration(one.first)));
  };
  if (idle.size() <= all_named) {
    for (const auto& one : idle) name("", one);
  } else {
    std::sort(idle.begin(), idle.end());
    name("least ", idle.front());
    name("median ", idle[idle.size() / 2]);
    name("most ", idle.back());
  }
  return fmt::format("idle: {}\n", fmt::join(parts, ", "));
}

}  // namespace

std::string run_text(const RunRecord& run) {
  double wall = 0;
  for (const mpi::RankTimes& rank : run.ranks) wall = std::max(wall, rank.busy + rank.idle);
  std::string text = fmt::format("{} on {} {}, busy {:.1f} % of the time until the last task began",
                                 core::human_duration(wall), run.ranks.size(),
                                 run.ranks.size() == 1 ? "rank" : "ranks", 100 * run.busy_fraction);
  if (run.computing_fraction)
    text += fmt::format(", computing {:.1f} %", 100 * *run.computing_fraction);
  text += "\n";
  text += idle_text(run.ranks);
  for (const auto& [kind, report] : run.estimates) {
    text += fmt::format(
        "{}: {} tasks took {:.2f} times their estimate (within a factor of {:.2f}); corrected "
        "as the build went, {:.2f} times ({:.2f})\n",
        kind, report.tasks, report.before.median, report.before.spread, report.after.median,
        report.after.spread);
  }
  return text;
}

std::vector<mpi::RankTimes> gather_times(const mpi::RankTimes& times, MPI_Comm world) {
  constexpr int values = sizeof(mpi::RankTimes) / sizeof(double);
  const bool host = mpi::rank(world) == 0;
  std::vector<mpi::RankTimes> all(host ? static_cast<std::size_t>(mpi::size(world)) : 0);
  MPI_Gather(&times, values, MPI_DOUBLE, all.data(), values, MPI_DOUBLE, 0, world);
  return all;
}

}  // namespace carillon::dataset::plan
