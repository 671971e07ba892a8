#include "eval/studies/detail/damping_validation.hpp"

#include <fmt/format.h>

#include <map>

#include "core/files.hpp"
#include "core/progress.hpp"
#include "core/trace.hpp"
#include "eval/scripts/run_script.hpp"
#include "eval/studies/detail/damping_fits.hpp"
#include "eval/studies/detail/damping_tables.hpp"
#include "eval/studies/detail/sound_features.hpp"
#include "eval/studies/detail/stage.hpp"
#include "eval/studies/evaluation.hpp"
#include "mpi/comm.hpp"
#include "mpi/journal.hpp"
#include "mpi/made_by.hpp"

namespace carillon::eval::studies {

using nlohmann::json;
using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

/// Estimated before anything is measured; they decide the order of tasks and nothing else.
constexpr double seconds_per_sound = 0.1;
constexpr double seconds_per_truth = 0.005;
constexpr double seconds_per_fit = 2e-3;
constexpr double seconds_per_sound_of_a_fit = 1e-3;

/// One validation on its way.
class Run {
 public:
  Run(const DampingValidation& validation, const EvaluatedDatasets& datasets, fs::path folder,
      MPI_Comm world)
      : validation_(validation),
        datasets_(datasets),
        folder_(std::move(folder)),
        world_(world),
        host_(mpi::rank(world) == 0),
        store_(datasets, sounds_, validation.keep_reverberant) {}

  EvaluationEnd run();

 private:
  Stage empty_stage(const char* name) const;
  StageEnd find_features();
  StageEnd fit();
  EvaluationEnd finish(double seconds);
  bool keep_stage(const char* name, const StageEnd& end);

  const DampingValidation& validation_;
  const EvaluatedDatasets& datasets_;
  fs::path folder_;
  const MPI_Comm world_;
  const bool host_;
  std::vector<SoundBlock> sounds_;
  FeatureStore store_;
  std::vector<FitBlock> fits_;
  FitResults results_;
  std::vector<json> failures_;
  ordered_json timing_ = ordered_json::object();
  ordered_json ran_ = ordered_json::object();
};

/// @return whether the run goes on
bool Run::keep_stage(const char* name, const StageEnd& end) {
  failures_.insert(failures_.end(), end.failures.begin(), end.failures.end());
  timing_[fmt::format("{}_s", name)] = end.seconds;
  timing_[fmt::format("{}_rank_s", name)] = end.rank_seconds;
  ran_[name] = end.tasks_run;
  return !end.interrupted;
}

Stage Run::empty_stage(const char* name) const {
  Stage stage;
  stage.name = name;
  stage.tell_interrupted = datasets_.options().tell_interrupted;
  return stage;
}

/// Features of all sounds; what is in a file is not computed again.
StageEnd Run::find_features() {
  mpi::agreed(world_, [&] {
    if (host_) core::remove_leftovers(folder_ / "features", true);
  });
  mpi::agreed(world_, [&] {
    sounds_ = sound_blocks(datasets_, validation_.sources, folder_ / "features");
  });
  // Equal shards of several datasets have one file.
  std::map<fs::path, std::size_t> first_of;
  std::vector<std::size_t> blocks;
  for (std::size_t b = 0; b < sounds_.size(); ++b) {
    if (first_of.emplace(sounds_[b].file, b).second) blocks.push_back(b);
  }
  Stage stage = empty_stage("features");
  for (const std::size_t b : blocks) {
    const bool truth = validation_.sources[sounds_[b].source].truth;
    stage.tasks.push_back({.key = sounds_[b].key,
                           .cost = static_cast<double>(sounds_[b].count) *
                                   (truth ? seconds_per_truth : seconds_per_sound)});
    stage.done.push_back(host_ && fs::exists(sounds_[b].file));
  }
  stage.work = [&](std::int64_t task) {
    const SoundBlock& block = sounds_[blocks[static_cast<std::size_t>(task)]];
    compute_features(block, datasets_.conditions()[block.condition],
                     validation_.sources[block.source], datasets_.cache());
    return std::string("{}");
  };
  StageEnd end = run_stage(stage, world_);
  std::map<std::string, fs::path> files;
  for (const SoundBlock& block : sounds_) files[block.key] = block.file;
  for (const json& failure : end.failures) {
    const fs::path lost = files.at(failure.at("task"));
    std::erase_if(sounds_, [&](const SoundBlock& block) { return block.file == lost; });
  }
  return end;
}

/// Fits to all sets of sounds; a journal keeps those of earlier runs.
StageEnd Run::fit() {
  mpi::agreed(world_, [&] { fits_ = fit_blocks(validation_, datasets_, store_); });
  // Where features are the same, so are the fits.
  std::map<std::string, std::size_t> first_of;
  std::vector<std::size_t> blocks;
  for (std::size_t b = 0; b < fits_.size(); ++b) {
    if (first_of.emplace(fits_[b].inputs, b).second) blocks.push_back(b);
  }
  std::map<std::string, json> by_inputs;
  std::unique_ptr<mpi::Journal> journal;
  mpi::agreed(world_, [&] {
    if (!host_) return;
    journal = std::make_unique<mpi::Journal>(folder_ / "damping-fits.jsonl");
    for (const json& entry : journal->entries()) by_inputs[entry.value("inputs", "")] = entry;
  });
  Stage stage = empty_stage("fits");
  for (const std::size_t b : blocks) {
    const double fits =
        static_cast<double>(validation_.draws) * static_cast<double>(validation_.estimators.size());
    stage.tasks.push_back(
        {.key = fits_[b].key,
         .cost = fits * (seconds_per_fit +
                         seconds_per_sound_of_a_fit * static_cast<double>(fits_[b].sounds))});
    stage.done.push_back(by_inputs.contains(fits_[b].inputs));
  }
  stage.work = [&](std::int64_t task) {
    return to_json(compute_fits(fits_[blocks[static_cast<std::size_t>(task)]], validation_,
                                datasets_, store_))
        .dump();
  };
  stage.completed = [&](std::int64_t task, const json& record) {
    journal->append(record);
    by_inputs[fits_[blocks[static_cast<std::size_t>(task)]].inputs] = record;
  };
  StageEnd end = run_stage(stage, world_);
  json results = json::array();
  for (const FitBlock& block : fits_) {
    const auto found = by_inputs.find(block.inputs);
    results.push_back(found == by_inputs.end() ? json() : found->second);
  }
  const json shared = json::parse(mpi::broadcast(results.dump(), 0, world_));
  for (const json& line : shared) {
    results_.push_back(line.is_null() ? std::nullopt : std::optional(fits_from(line)));
  }
  return end;
}

/// Tables, files and the picture.
EvaluationEnd Run::finish(double seconds) {
  EvaluationEnd end{failures_.empty() ? mpi::exit_done : mpi::exit_failures};
  const double start = core::monotonic_seconds();
  DampingFindings findings = find_errors(validation_, datasets_, fits_, results_, world_);
  ordered_json document;
  mpi::agreed(world_, [&] {
    if (!host_) return;
    findings.features = count_features(validation_, datasets_, store_);
    document = damping_json(validation_, datasets_, findings, failures_);
    const fs::path path = folder_ / "damping.json";
    core::write_text_durably(path, document.dump(1) + "\n");
    core::write_text_durably(folder_ / "damping-errors.csv", csv_of(document["errors"]));
    core::write_text_durably(folder_ / "damping-tests.csv", csv_of(document["tests"]));
    core::write_text_durably(folder_ / "damping-fits.csv",
                             fits_csv(validation_, datasets_, fits_, results_));
    timing_["tables_s"] = core::monotonic_seconds() - start;
    const std::string no_picture = scripts::draw_picture("plot_damping_validation", path);
    timing_["picture_s"] = core::monotonic_seconds() - start - timing_["tables_s"].get<double>();
    timing_["damping_s"] = seconds + core::monotonic_seconds() - start;
    bool worked = false;
    for (const ordered_json& tasks : ran_) worked = worked || tasks > 0;
    keep_evaluation_trace(folder_ / "damping-trace.json", worked,
                          {{"timing", timing_}, {"tasks_run", ran_}},
                          mpi::made_by(datasets_.options().command, world_));
    document["output"] = folder_.string();
    document["tasks_run"] = ran_;
    document["timing"] = timing_;
    document["interrupted"] = false;
    end.text = damping_text(validation_, datasets_, findings);
    for (const auto& [name, value] : timing_.items()) {
      if (name.ends_with("_rank_s")) continue;
      end.text += fmt::format("{}{} {}", name == "features_s" ? "\n" : ", ",
                              name.substr(0, name.size() - 2), core::human_duration(value));
    }
    end.text += fmt::format(
        "\n{}: damping.json, damping-errors.csv, damping-tests.csv, damping-fits.csv{}\n",
        folder_.string(), no_picture.empty() ? ", damping.svg, damping.png" : "");
    for (const json& failure : failures_) {
      end.text += fmt::format("failed: {}: {}\n", failure.at("task").get<std::string>(),
                              failure.at("message").get<std::string>());
    }
    if (!no_picture.empty()) fmt::print(stderr, "carillon: {}\n", no_picture);
  });
  end.document = std::move(document);
  return end;
}

EvaluationEnd Run::run() {
  const double start = core::monotonic_seconds();
  if (!keep_stage("features", find_features())) return {mpi::exit_interrupted};
  if (!keep_stage("fits", fit())) return {mpi::exit_interrupted};
  return finish(core::monotonic_seconds() - start);
}

}  // namespace

RunEvaluation read_damping_validation(core::ConfigNode& node, core::ConfigNode&,
                                      const EvaluatedDatasets& datasets) {
  for (const Condition& condition : datasets.conditions()) {
    if (condition.build != nullptr) continue;
    node.fail("", fmt::format("the damping of {} is not known", condition.folder.string()),
              "damping validation builds its own datasets: give objects and materials, not `data`");
  }
  return [validation = read_damping_config(node, datasets), &datasets](const fs::path& folder,
                                                                       MPI_Comm world) {
    return Run(validation, datasets, folder, world).run();
  };
}

}  // namespace carillon::eval::studies
