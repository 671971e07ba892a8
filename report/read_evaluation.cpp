#include <fmt/format.h>

#include <map>
#include <utility>

#include "core/error.hpp"
#include "core/json.hpp"
#include "report/report.hpp"

namespace carillon::report {

using nlohmann::ordered_json;
using namespace std::string_literals;
namespace fs = std::filesystem;

namespace {

/// Errors of all materials together are shown; those of each are in the folder.
void shorten(ordered_json& damping) {
  for (const char* list : {"errors", "tests"}) {
    ordered_json kept = ordered_json::array();
    for (ordered_json& row : damping[list]) {
      if (row.value("material", "") == "all") kept.push_back(std::move(row));
    }
    damping[list] = std::move(kept);
  }
}

/// Seconds that the features of one sound took, of all ranks; null where no run has measured it. A
/// run that went on with an earlier one's features measured those that were left.
ordered_json seconds_per_sound(const ordered_json& damping, const fs::path& folder) {
  if (!fs::is_regular_file(folder / "damping-trace.json") ||
      !fs::is_directory(folder / "features")) {
    return nullptr;
  }
  const ordered_json trace = read_document(folder, "damping-trace.json", "tasks_run");
  const double run = trace.at("tasks_run").value("features", 0.0);
  double files = 0, sounds = 0;
  for ([[maybe_unused]] const auto& file : fs::directory_iterator(folder / "features")) ++files;
  for (const ordered_json& source : damping.at("found_features")) {
    if (source.at("features") == damping.at("features").front()) {
      sounds += source.at("sounds").get<double>();
    }
  }
  if (!(run > 0 && sounds > 0)) return nullptr;
  return trace.at("timing").at("features_rank_s").get<double>() * files / run / sounds;
}

}  // namespace

ordered_json read_document(const fs::path& folder, const std::string& name,
                           const std::string& key) {
  ordered_json read = core::read_ordered_json(folder / name);
  if (!read.is_object() || !read.contains(key)) {
    throw core::FileError(fmt::format("{} is damaged, or another kind of file: it has no \"{}\"",
                                      (folder / name).string(), key));
  }
  read["folder"] = folder.string();
  for (const std::string& trace : {fs::path(name).stem().string() + "-trace.json", "trace.json"s}) {
    const ordered_json told = core::read_ordered_json(folder / trace);
    if (read.contains("made") || !told.is_object()) continue;
    const ordered_json runs = told.value("runs", ordered_json::array());
    const ordered_json& last = runs.empty() ? told : runs.back();
    if (last.contains("made")) read["made"] = last["made"];
  }
  return read;
}

ordered_json read_classification(const fs::path& folder) {
  ordered_json read = read_document(folder, "classification.json", "rows");
  std::map<std::pair<std::string, std::string>, std::pair<double, ordered_json*>> best;
  for (ordered_json& row : read.at("rows")) {
    const double right = row.at("accuracy").at("mean");
    const auto [place, first] = best.try_emplace({row.at("dataset"), row.at("task")}, right, &row);
    if (first) continue;
    ordered_json& less = right > place->second.first ? *place->second.second : row;
    if (right > place->second.first) place->second = {right, &row};
    less.erase("confusion");
  }
  return read;
}

ordered_json read_damping(const fs::path& folder) {
  ordered_json damping = read_document(folder, "damping.json", "errors");
  shorten(damping);
  damping["seconds_per_sound"] = seconds_per_sound(damping, folder);
  return damping;
}

}  // namespace carillon::report
