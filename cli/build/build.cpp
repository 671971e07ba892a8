#include "cli/build/build.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "cli/build/dataset.hpp"
#include "cli/build/samples_task.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/progress.hpp"
#include "mpi/comm.hpp"
#include "mpi/journal.hpp"
#include "mpi/task_service.hpp"

namespace carillon::cli {

namespace {

using nlohmann::json;

json to_json(const core::Trace& trace) {
  const auto entries = [](const std::map<std::string, core::Trace::Entry>& map) {
    json out = json::object();
    for (const auto& [name, entry] : map) {
      out[name] = {{"calls", entry.calls}, {"seconds", entry.seconds}};
    }
    return out;
  };
  return {{"stages", entries(trace.stages)}, {"effects", entries(trace.effects)}};
}

core::Trace trace_from_json(const json& document) {
  core::Trace trace;
  const auto read = [](const json& from, std::map<std::string, core::Trace::Entry>& to) {
    for (const auto& [name, entry] : from.items()) {
      to[name] = {entry.at("calls").get<std::int64_t>(), entry.at("seconds").get<double>()};
    }
  };
  read(document.at("stages"), trace.stages);
  read(document.at("effects"), trace.effects);
  return trace;
}

/// Refuses to build over a folder that another configuration made, and says what differs.
void check_configuration(const BuildConfig& config, const std::filesystem::path& output) {
  const std::filesystem::path path = output / "configuration.yaml";
  if (!std::filesystem::exists(path)) {
    core::write_text_durably(path, config.resolved);
    return;
  }
  const std::string old = core::read_file(path);
  if (old == config.resolved) return;
  const auto lines = [](const std::string& text) {
    std::multiset<std::string> set;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) set.insert(line);
    return set;
  };
  const auto before = lines(old), now = lines(config.resolved);
  std::string difference;
  for (const std::string& line : before) {
    if (!now.contains(line)) difference += "\n  - " + line;
  }
  for (const std::string& line : now) {
    if (!before.contains(line)) difference += "\n  + " + line;
  }
  throw core::ConfigError(
      fmt::format("{} was built with another configuration:{}", output.string(), difference),
      "choose another folder with --output, or remove this one");
}

/// Outcome of every task as the journal tells it; a later line counts more than an earlier one.
/// A task whose files are not there any more is not done.
std::map<std::string, json> finished_tasks(const mpi::Journal& journal,
                                           const std::filesystem::path& output) {
  std::map<std::string, json> finished;
  for (const json& entry : journal.entries()) finished[entry.at("task")] = entry;
  std::erase_if(finished, [&](const auto& item) {
    for (const json& file : item.second.value("files", json::array())) {
      std::error_code error;
      const auto path = output / file.at("path").get<std::string>();
      const auto bytes = std::filesystem::file_size(path, error);
      if (error || bytes != file.at("bytes").get<std::uintmax_t>()) return true;
    }
    return false;
  });
  return finished;
}

json describe_files(const std::vector<std::string>& written, const std::filesystem::path& output) {
  json files = json::array();
  for (const std::string& path : written) {
    files.push_back({{"path", path},
                     {"sha256", core::sha256_file(output / path)},
                     {"bytes", std::filesystem::file_size(output / path)}});
  }
  return files;
}

/// The part of the plan that is still to be done.
struct Remaining {
  std::vector<mpi::Task> tasks;
  std::vector<std::size_t> index;  ///< of each in BuildPlan::tasks
};

/// Leaves out what is done, what failed before (unless it is tried again) and what waits for that.
Remaining remaining_tasks(const LoadedBuild& build, const std::map<std::string, json>& finished,
                          bool retry_failed) {
  const std::vector<mpi::Task> all = board_tasks(build.plan, build.config);
  std::vector<std::int64_t> place(all.size(), -1);  // done: -1, dropped: -2
  Remaining remaining;
  for (std::size_t t = 0; t < all.size(); ++t) {
    const auto found = finished.find(all[t].key);
    if (found != finished.end()) {
      const bool ok = found->second.at("ok").get<bool>();
      if (ok) continue;
      if (!retry_failed) {
        place[t] = -2;
        continue;
      }
    }
    mpi::Task task = all[t];
    task.after.clear();
    bool dropped = false;
    for (const std::int64_t before : all[t].after) {
      const std::int64_t at = place[static_cast<std::size_t>(before)];
      dropped = dropped || at == -2;
      if (at >= 0) task.after.push_back(at);
    }
    if (dropped) {
      place[t] = -2;
      continue;
    }
    place[t] = static_cast<std::int64_t>(remaining.tasks.size());
    remaining.tasks.push_back(std::move(task));
    remaining.index.push_back(t);
  }
  return remaining;
}

std::string reproduce(const LoadedBuild& build, const BuildTask& task) {
  const Shape& shape = build.plan.shapes[task.shape];
  if (!shape.path.empty()) {
    std::string command = fmt::format("carillon modes {} --material {}", shape.path,
                                      shape.variants.front().material);
    if (shape.request.file.length > 0) {
      command += fmt::format(" --length {}", shape.request.file.length);
    }
    return command;
  }
  std::vector<std::string> values;
  for (const auto& [name, value] : shape.request.shape.parameters) {
    values.push_back(fmt::format("{}={}", name, value));
  }
  return fmt::format("carillon modes {}:{} --material {}", shape.family, fmt::join(values, ","),
                     shape.variants.front().material);
}

/// Index, descriptions and failures from all that the journal knows. Returns the failed tasks.
std::size_t write_results(const LoadedBuild& build, const BuildFolders& folders) {
  const mpi::Journal journal(folders.output / "journal.jsonl");
  const auto finished = finished_tasks(journal, folders.output);
  std::vector<std::size_t> done;
  json files = json::array(), failures = json::array();
  for (std::size_t t = 0; t < build.plan.tasks.size(); ++t) {
    const BuildTask& task = build.plan.tasks[t];
    const auto found = finished.find(task.key);
    if (found == finished.end()) continue;
    const json& entry = found->second;
    if (entry.at("ok").get<bool>()) {
      if (task.kind == TaskKind::samples) done.push_back(t);
      for (const json& file : entry.at("files")) files.push_back(file);
    } else {
      failures.push_back({{"task", task.key},
                          {"kind", entry.value("kind", "Error")},
                          {"message", entry.value("message", "")},
                          {"reproduce", reproduce(build, task)}});
    }
  }
  write_index(build.plan, done, folders);
  write_descriptions(build.config, build.plan, files, failures, folders);
  return failures.size();
}

}  // namespace

LoadedBuild load_build(const BuildOptions& options, MPI_Comm world) {
  std::string text;
  mpi::agreed(world, [&] {
    if (mpi::rank(world) == 0) text = core::read_text_file(options.config);
  });
  text = mpi::broadcast(text, 0, world);
  LoadedBuild build;
  mpi::agreed(world, [&] {
    build.config = read_build_config(text, options.config, options.overrides);
    build.plan = make_plan(build.config);
  });
  const auto plans = mpi::all_gather(fingerprint(build.plan), world);
  for (const std::string& plan : plans) {
    if (plan != plans.front()) {
      throw core::InputError("the ranks do not see the same files",
                             "the folders of the configuration must be on a shared file system");
    }
  }
  return build;
}

int run_build(const BuildOptions& options, const Context& context) {
  const LoadedBuild build = load_build(options, context.world);
  BuildFolders folders;
  folders.output = options.output.empty() ? build.config.name : options.output;
  folders.cache = context.cache;
  const bool host = context.speaks();
  const mpi::FolderLock lock(folders.output, context.world);

  std::unique_ptr<mpi::Journal> journal;
  Remaining remaining;
  std::string packed;
  mpi::agreed(context.world, [&] {
    if (!host) return;
    check_configuration(build.config, folders.output);
    journal = std::make_unique<mpi::Journal>(folders.output / "journal.jsonl");
    remaining =
        remaining_tasks(build, finished_tasks(*journal, folders.output), options.retry_failed);
    packed = json(remaining.index).dump();
  });
  // Every rank knows what the numbers of the board's tasks mean.
  remaining.index = json::parse(mpi::broadcast(packed, 0, context.world))
                        .get<std::vector<std::size_t>>();

  core::Trace trace;
  mpi::RunReport report;
  if (!remaining.index.empty()) {
    const double total = mpi::TaskBoard(remaining.tasks).total_cost();
    core::Progress progress("build", total, context.quiet || !host);
    mpi::ServiceHooks hooks;
    hooks.completed = [&](const mpi::Task& task, const mpi::Outcome& outcome) {
      json entry = json::parse(outcome.record);
      entry["task"] = task.key;
      entry["ok"] = outcome.ok;
      journal->append(entry);
    };
    hooks.progress = [&](const mpi::TaskBoard& board) {
      progress.update(board.settled_cost(),
                      fmt::format("{} of {} tasks", board.count(mpi::TaskState::done),
                                  board.tasks().size()));
    };
    report = mpi::run_tasks(
        context.world, mpi::TaskBoard(remaining.tasks), hooks, 1,
        [&](std::int64_t number, MPI_Comm group) {
          const BuildTask& task =
              build.plan.tasks[remaining.index[static_cast<std::size_t>(number)]];
          const double start = core::monotonic_seconds();
          std::vector<std::string> written;
          core::Trace own;
          if (task.kind == TaskKind::modes) {
            written = run_modes_task(build.config, build.plan.shapes[task.shape], folders, group, own);
          } else if (mpi::rank(group) == 0) {
            written = run_samples_task(build.config, build.plan, task, folders, own);
          }
          trace.merge(own);
          const double seconds = core::monotonic_seconds() - start;
          return json{{"files", describe_files(written, folders.output)},
                      {"seconds", seconds},
                      {"trace", to_json(own)}}
              .dump();
        });
    progress.finish("");
  }
  journal.reset();

  const auto traces = mpi::all_gather(to_json(trace).dump(), context.world);
  int exit_code = exit_done;
  mpi::agreed(context.world, [&] {
    if (!host) return;
    core::Trace sum;
    for (const std::string& one : traces) sum.merge(trace_from_json(json::parse(one)));
    const std::size_t failed = write_results(build, folders);
    if (!remaining.index.empty()) {
      json document = to_json(sum);
      document["ranks"] = report.ranks_json();
      core::write_text_durably(folders.output / "trace.json", document.dump(2) + "\n");
    }
    exit_code = report.interrupted ? exit_interrupted : failed > 0 ? exit_failures : exit_done;
    const json summary = {{"output", folders.output.string()},
                          {"shapes", build.plan.shapes.size()},
                          {"samples", build.plan.samples.size()},
                          {"tasks_run", remaining.index.size()},
                          {"failed_tasks", failed},
                          {"interrupted", report.interrupted},
                          {"exit_code", exit_code}};
    if (context.json) {
      fmt::print("{}\n", summary.dump(2));
      return;
    }
    if (remaining.index.empty()) {
      fmt::print("nothing to do: {} holds all {} samples of {} shapes\n", folders.output.string(),
                 build.plan.samples.size(), build.plan.shapes.size());
    } else {
      fmt::print("{} samples of {} shapes in {}\n", build.plan.samples.size(),
                 build.plan.shapes.size(), folders.output.string());
    }
    if (report.interrupted) fmt::print("interrupted: run the same command to go on\n");
    if (failed > 0) {
      fmt::print("{} failed tasks: see {}\n", failed, (folders.output / "failures.json").string());
    }
  });
  return std::stoi(mpi::broadcast(std::to_string(exit_code), 0, context.world));
}

}  // namespace carillon::cli
