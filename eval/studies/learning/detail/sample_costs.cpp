#include "eval/studies/learning/detail/sample_costs.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/hdf5.hpp"
#include "core/json.hpp"

namespace carillon::eval::studies {

namespace {

/// What a build took for each sample [s]: in all, and for effects that datasets share.
struct SampleCost {
  double all = 0;
  std::map<std::string, double> shared;
};

std::optional<SampleCost> sample_cost(const Condition& condition) {
  const std::filesystem::path path = condition.folder / "trace.json";
  if (condition.recordings || !std::filesystem::exists(path)) return std::nullopt;
  const nlohmann::json trace = core::read_json(path);
  const auto file = core::Hdf5Group::open_file(condition.folder / "index.h5");
  const auto samples = static_cast<double>(file.extent("key").front());
  SampleCost cost;
  for (const nlohmann::json& task : trace.at("tasks")) {
    if (task.at("kind") == "samples") cost.all += task.at("seconds").get<double>() / samples;
  }
  // Rooms and fits are computed once, for the first dataset that needs them.
  for (const char* effect : {"radiation", "room"}) {
    if (!trace.at("effects").contains(effect)) continue;
    cost.shared[effect] = trace["effects"][effect].at("seconds").get<double>() / samples;
  }
  return cost;
}

}  // namespace

std::vector<std::optional<double>> seconds_per_sample(const std::vector<Condition>& conditions) {
  std::vector<std::optional<SampleCost>> costs;
  std::map<std::string, double> longest;
  for (const Condition& condition : conditions) {
    costs.push_back(sample_cost(condition));
    if (!costs.back()) continue;
    for (const auto& [effect, seconds] : costs.back()->shared) {
      longest[effect] = std::max(longest[effect], seconds);
    }
  }
  std::vector<std::optional<double>> sums;
  for (const std::optional<SampleCost>& own : costs) {
    sums.emplace_back();
    if (!own) continue;
    sums.back() = own->all;
    for (const auto& [effect, seconds] : own->shared) *sums.back() += longest.at(effect) - seconds;
  }
  return sums;
}

}  // namespace carillon::eval::studies
