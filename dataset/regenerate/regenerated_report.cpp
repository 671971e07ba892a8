#include <fmt/format.h>

#include <algorithm>

#include "dataset/regenerate/regenerate.hpp"

namespace carillon::dataset::regenerate {

using nlohmann::json;

bool Regenerated::as_expected() const {
  return !changed.empty() ||
         std::all_of(samples.begin(), samples.end(),
                     [](const RegeneratedSample& sample) { return sample.identical(); });
}

namespace {

json to_json(const ColumnDifference& difference) {
  json out = {
      {"column", difference.column}, {"stored", difference.stored}, {"made", difference.made}};
  if (difference.difference_db) out["difference_db"] = *difference.difference_db;
  return out;
}

json to_json(const RegeneratedSample& sample) {
  json out = {{"key", sample.key},
              {"id", sample.id},
              {"stored", sample.stored},
              {"identical", sample.stored ? json(sample.identical()) : json()},
              {"record", sample.record}};
  if (sample.stored) {
    out["differences"] = json::array();
    for (const ColumnDifference& one : sample.differences) {
      out["differences"].push_back(to_json(one));
    }
  }
  if (!sample.wav.empty()) out["wav"] = sample.wav;
  return out;
}

std::string text_of(const ColumnDifference& difference) {
  const auto& [column, stored, made, level] = difference;
  const auto text = [](const json& value) { return value.is_null() ? "nothing" : value.dump(); };
  if (!level) return fmt::format("{}: stored {}, made {}", column, text(stored), text(made));
  return *level < 1e6 ? fmt::format("{}: differs by {:.1f} dB of its energy", column, *level)
                      : fmt::format("{}: is silent on one side", column);
}

}  // namespace

json to_json(const Regenerated& made) {
  json samples = json::array(), modes = json::array();
  for (const RegeneratedSample& sample : made.samples) samples.push_back(to_json(sample));
  for (const SolvedAgain& solved : made.modes) {
    modes.push_back({{"shape", solved.shape}, {"why", solved.why}});
  }
  json versions = json::object();
  for (const auto& [name, version] : made.versions) {
    versions[name] = {{"stored", version.stored}, {"here", version.here}};
  }
  return {{"dataset", made.dataset}, {"changed", made.changed}, {"samples", samples},
          {"versions", versions},    {"doubts", made.doubts},   {"modes", modes}};
}

std::string regenerated_text(const Regenerated& made) {
  std::string text;
  for (const RegeneratedSample& sample : made.samples) {
    text +=
        fmt::format("{}: {}\n", sample.key,
                    sample.identical() ? "identical"
                    : sample.stored    ? fmt::format("{} columns differ", sample.differences.size())
                                       : "made; the dataset does not hold it");
    for (const ColumnDifference& difference : sample.differences) {
      text += fmt::format("  {}\n", text_of(difference));
    }
    if (!sample.wav.empty()) text += fmt::format("  {}\n", sample.wav);
  }
  for (const auto& [name, version] : made.versions) {
    text += fmt::format("{}: built with {}, here {}\n", name, version.stored.dump(),
                        version.here.dump());
  }
  return text;
}

}  // namespace carillon::dataset::regenerate
