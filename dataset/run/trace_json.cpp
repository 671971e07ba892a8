#include "dataset/run/trace_json.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

json entries_json(const std::map<std::string, core::Trace::Entry>& entries) {
  json out = json::object();
  for (const auto& [name, entry] : entries) {
    out[name] = {{"calls", entry.calls}, {"seconds", entry.seconds}};
  }
  return out;
}

void read_entries(const json& from, std::map<std::string, core::Trace::Entry>& to) {
  for (const auto& [name, entry] : from.items()) {
    to[name] = {entry.at("calls").get<std::int64_t>(), entry.at("seconds").get<double>()};
  }
}

core::Trace trace_from_json(const json& document) {
  core::Trace trace;
  read_entries(document.at("stages"), trace.stages);
  read_entries(document.at("effects"), trace.effects);
  return trace;
}

}  // namespace

json to_json(const core::Trace& trace) {
  return {{"stages", entries_json(trace.stages)}, {"effects", entries_json(trace.effects)}};
}

core::Trace trace_of(const json& entry) {
  core::Trace sum;
  if (entry.contains("trace")) sum.merge(trace_from_json(entry.at("trace")));
  if (entry.contains("kept")) sum.merge(trace_from_json(entry.at("kept")));
  return sum;
}

core::Trace total_trace(const std::map<std::string, json>& finished) {
  core::Trace sum;
  for (const auto& [task, entry] : finished) sum.merge(trace_of(entry));
  return sum;
}

}  // namespace carillon::dataset::run
