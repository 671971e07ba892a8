#include "dataset/run/keep_trace.hpp"

#include "core/files.hpp"
#include "core/json.hpp"
#include "dataset/configuration/inputs.hpp"
#include "dataset/run/trace_json.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

json document_of(const FolderTrace& trace) {
  json document = to_json(trace.ran);
  if (trace.configuration_folder) document["configuration_folder"] = *trace.configuration_folder;
  document["missed_pitch_targets"] = trace.missed_pitch_targets;
  document["tasks"] = plan::to_json(trace.tasks);
  return document;
}

}  // namespace

FolderTrace folder_trace(const LoadedBuild& build, const std::map<std::string, json>& finished,
                         const Results& results) {
  return {total_trace(finished), configuration::configuration_folder(build.path),
          results.missed.size(), plan::task_rows(finished)};
}

std::optional<plan::RunRecord> keep_trace(const std::filesystem::path& folder,
                                          const FolderTrace& trace, const RunOutcome* outcome,
                                          const json& made) {
  const std::filesystem::path path = folder / "trace.json";
  json document = document_of(trace);
  json old = json::object();
  try {
    if (json read = core::read_json(path); read.is_object()) old = std::move(read);
  } catch (const std::exception&) {
    // Only times are lost.
  }
  const bool ran = outcome != nullptr && outcome->tasks_run() > 0;
  if (!ran && old.value("tasks", json()) == document["tasks"]) return {};
  for (const char* key : {"runs", "ranks", "index"}) {
    if (old.contains(key)) document[key] = old[key];
  }
  std::optional<plan::RunRecord> record;
  if (ran) {
    record = {outcome->run,
              outcome->ranks,
              plan::busy_fraction(trace.tasks, outcome->run, outcome->ranks),
              plan::computing_fraction(trace.tasks, outcome->run, outcome->ranks),
              outcome->calibration.report(),
              made};
    document["index"] = {{"calls", outcome->index.calls}, {"seconds", outcome->index.seconds}};
    document["runs"].push_back(plan::to_json(*record));
    document["ranks"] = plan::to_json(record->ranks);
  }
  core::write_text_durably(path, document.dump(2) + "\n");
  return record;
}

}  // namespace carillon::dataset::run
