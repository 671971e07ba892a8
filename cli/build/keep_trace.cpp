#include "cli/build/keep_trace.hpp"

#include "cli/build/inputs.hpp"
#include "cli/build/task_times.hpp"
#include "cli/build/trace_json.hpp"
#include "cli/made_by.hpp"
#include "core/files.hpp"

namespace carillon::cli {

using nlohmann::json;

json describe_trace(const LoadedBuild& build, const std::map<std::string, json>& finished,
                    const Results& results) {
  json document = to_json(total_trace(finished));
  document["configuration_folder"] = configuration_folder(build.path);
  document["missed_pitch_targets"] = results.missed.size();
  document["tasks"] = task_rows(finished);
  return document;
}

void keep_trace(const std::filesystem::path& folder, json& document, const RunOutcome* outcome,
                const Context& context) {
  const std::filesystem::path path = folder / "trace.json";
  json old = json::object();
  try {
    if (std::filesystem::exists(path)) old = json::parse(core::read_file(path));
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
    json run =
        describe_run(outcome->run, outcome->ranks, outcome->calibration, document.at("tasks"));
    run["made"] = made_by(context);
    document["runs"].push_back(std::move(run));
    document["ranks"] = document["runs"].back().at("ranks");
  }
  core::write_text_durably(path, document.dump(2) + "\n");
}

}  // namespace carillon::cli
