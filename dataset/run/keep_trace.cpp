#include "dataset/run/keep_trace.hpp"

#include "core/files.hpp"
#include "core/json.hpp"
#include "dataset/configuration/inputs.hpp"
#include "dataset/plan/task_times.hpp"
#include "dataset/run/trace_json.hpp"
#include "mpi/made_by.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

json describe_trace(const LoadedBuild& build, const std::map<std::string, json>& finished,
                    const Results& results) {
  json document = to_json(total_trace(finished));
  document["configuration_folder"] = configuration::configuration_folder(build.path);
  document["missed_pitch_targets"] = results.missed.size();
  document["tasks"] = plan::task_rows(finished);
  return document;
}

void keep_trace(const std::filesystem::path& folder, json& document, const RunOutcome* outcome,
                const mpi::Context& context) {
  const std::filesystem::path path = folder / "trace.json";
  json old = json::object();
  try {
    if (json read = core::read_json(path); read.is_object()) old = std::move(read);
  } catch (const std::exception&) {
    // Only times are lost.
  }
  const bool ran = outcome != nullptr && outcome->tasks_run() > 0;
  if (!ran && old.value("tasks", json()) == document.at("tasks")) return;
  for (const char* key : {"runs", "ranks", "index"}) {
    if (old.contains(key)) document[key] = old.at(key);
  }
  if (ran) {
    document["index"] = {{"calls", outcome->index.calls}, {"seconds", outcome->index.seconds}};
    json run = plan::describe_run(outcome->run, outcome->ranks, outcome->calibration,
                                  document.at("tasks"));
    run["made"] = mpi::made_by(context);
    document["runs"].push_back(std::move(run));
    document["ranks"] = document["runs"].back().at("ranks");
  }
  core::write_text_durably(path, document.dump(2) + "\n");
}

}  // namespace carillon::dataset::run
