#include "dataset/plan/task_times.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/json.hpp"
#include "core/progress.hpp"
#include "mpi/comm.hpp"

namespace carillon::dataset::plan {

using nlohmann::json;

json describe_times(const mpi::Task& task, const mpi::TaskTimes& times, int run) {
  return {{"run", run},
          {"kind", task.kind},
          {"estimate_s", task.cost / task.width},
          {"seconds", times.seconds},
          {"cpu_s", times.cpu},
          {"queued_s", times.queued},
          {"rank", times.rank},
          {"width", times.width},
          {"start_s", times.start}};
}

int next_run(const std::vector<json>& journal) {
  int last = 0;
  for (const json& entry : journal) {
    if (entry.contains("times")) last = std::max(last, entry.at("times").at("run").get<int>());
  }
  return last + 1;
}

json task_rows(const std::map<std::string, json>& finished) {
  json rows = json::array();
  for (const auto& [task, entry] : finished) {
    if (!entry.contains("times")) continue;
    json row = entry.at("times");
    row["task"] = task;
    rows.push_back(std::move(row));
  }
  std::sort(rows.begin(), rows.end(), [](const json& a, const json& b) {
    const auto order = [](const json& row) {
      return std::pair(row.at("run").get<int>(), row.at("start_s").get<double>());
    };
    return order(a) < order(b);
  });
  return rows;
}

namespace {

/// When the last task of a run began [s].
double last_start(const json& rows, int run) {
  double last = 0;
  for (const json& row : rows) {
    if (row.at("run") == run) last = std::max(last, row.at("start_s").get<double>());
  }
  return last;
}

}  // namespace

double busy_fraction(const json& rows, int run, const std::vector<mpi::RankTimes>& ranks) {
  const double last = last_start(rows, run);
  double cpu = 0, in_tasks = 0, queued = 0;
  for (const mpi::RankTimes& rank : ranks) queued += rank.queued;
  for (const json& row : rows) {
    const auto seconds = row.at("seconds").get<double>();
    if (row.at("run") != run || seconds <= 0) continue;
    const double until_last = std::min(seconds, last - row.at("start_s").get<double>());
    cpu += row.at("cpu_s").get<double>() * until_last / seconds;
    const auto width = row.at("width").get<double>();
    in_tasks += until_last * width;
    // What a group's ranks neither compute nor queue for, they wait for each other.
    if (width > 1) {
      const double waiting =
          seconds * width - row.at("cpu_s").get<double>() - row.at("queued_s").get<double>();
      in_tasks -= std::max(0.0, waiting) * until_last / seconds;
    }
    queued -= row.at("queued_s").get<double>();
  }
  const double between = static_cast<double>(ranks.size()) * last - in_tasks;
  const double idle = std::max(0.0, between - std::max(0.0, queued));
  return cpu + idle > 0 ? cpu / (cpu + idle) : 1;
}

double computing_fraction(const json& rows, int run, const std::vector<mpi::RankTimes>& ranks) {
  const double last = last_start(rows, run);
  double cpu = 0, queued = 0;
  for (const mpi::RankTimes& rank : ranks) queued += rank.queued;
  for (const json& row : rows) {
    const auto seconds = row.at("seconds").get<double>();
    if (row.at("run") != run || seconds <= 0) continue;
    const double part = std::min(1.0, (last - row.at("start_s").get<double>()) / seconds);
    cpu += row.at("cpu_s").get<double>() * part;
    // Of what other programs took, the part after the last task's beginning.
    queued -= row.at("queued_s").get<double>() * (1 - part);
  }
  const double available = static_cast<double>(ranks.size()) * last - std::max(0.0, queued);
  return available > 0 ? std::min(1.0, cpu / available) : 1;
}

namespace {

json to_json(const mpi::EstimateError& error) {
  return {{"median", error.median}, {"spread", error.spread}};
}

}  // namespace

json describe_run(int run, const std::vector<mpi::RankTimes>& ranks,
                  const mpi::Calibration& calibration, const json& rows) {
  json out = {{"run", run}, {"ranks", json::array()}, {"estimates", json::object()}};
  for (const mpi::RankTimes& rank : ranks) {
    out["ranks"].push_back({{"busy_s", rank.busy},
                            {"idle_s", rank.idle},
                            {"cpu_s", rank.cpu},
                            {"queued_s", rank.queued},
                            {"peak_memory_bytes", rank.peak_memory}});
  }
  out["busy_fraction"] = busy_fraction(rows, run, ranks);
  out["computing_fraction"] = computing_fraction(rows, run, ranks);
  for (const auto& [kind, report] : calibration.report()) {
    out["estimates"][kind] = {{"tasks", report.tasks},
                              {"before", to_json(report.before)},
                              {"after", to_json(report.after)}};
  }
  return out;
}

json earlier_runs(const std::filesystem::path& trace) {
  try {
    return core::read_json(trace).value("runs", json::array());
  } catch (const std::exception&) {
    return json::array();  // only times are lost
  }
}

namespace {

/// What each rank was idle, or, of many, the least, the middle and the most idle one.
std::string idle_text(const json& ranks) {
  constexpr std::size_t all_named = 8;
  std::vector<std::pair<double, std::size_t>> idle;
  for (std::size_t r = 0; r < ranks.size(); ++r) {
    idle.emplace_back(ranks[r].at("idle_s").get<double>(), r);
  }
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

std::string run_text(const json& run) {
  double wall = 0;
  for (const json& rank : run.at("ranks")) {
    wall = std::max(wall, rank.at("busy_s").get<double>() + rank.at("idle_s").get<double>());
  }
  std::string text = fmt::format("{} on {} {}, busy {:.1f} % of the time until the last task began",
                                 core::human_duration(wall), run.at("ranks").size(),
                                 run.at("ranks").size() == 1 ? "rank" : "ranks",
                                 100 * run.at("busy_fraction").get<double>());
  // Runs of earlier versions do not tell.
  if (run.contains("computing_fraction")) {
    text += fmt::format(", computing {:.1f} %", 100 * run.at("computing_fraction").get<double>());
  }
  text += "\n";
  text += idle_text(run.at("ranks"));
  for (const auto& entry : run.at("estimates").items()) {
    const auto& report = entry.value();
    const auto number = [&](const char* when, const char* what) {
      return report.at(when).at(what).template get<double>();
    };
    text += fmt::format(
        "{}: {} tasks took {:.2f} times their estimate (within a factor of {:.2f}); corrected "
        "as the build went, {:.2f} times ({:.2f})\n",
        entry.key(), report.at("tasks").template get<std::int64_t>(), number("before", "median"),
        number("before", "spread"), number("after", "median"), number("after", "spread"));
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
