#include "dataset/check/report.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace carillon::dataset::check {

Finding judged(const std::string& check, std::vector<std::string> items, const std::string& passed,
               const std::string& failed, const std::string& remedy) {
  if (items.empty()) return {check, Verdict::pass, passed, "", {}};
  return {check, Verdict::fail, failed, remedy, std::move(items)};
}

std::string name_of(Verdict verdict) {
  return verdict == Verdict::pass ? "pass" : verdict == Verdict::note ? "note" : "fail";
}

nlohmann::json to_json(const Finding& finding) {
  return {{"name", finding.check},
          {"verdict", name_of(finding.verdict)},
          {"text", finding.text},
          {"remedy", finding.remedy},
          {"items", finding.items}};
}

bool all_pass(const std::vector<Finding>& findings) {
  return std::none_of(findings.begin(), findings.end(),
                      [](const Finding& finding) { return finding.verdict == Verdict::fail; });
}

void print(const std::vector<Finding>& findings) {
  constexpr std::size_t max_lines = 5;
  for (const Finding& finding : findings) {
    const bool failed = finding.verdict == Verdict::fail;
    fmt::print("  {}  {:<13} {}\n", failed ? "FAIL" : name_of(finding.verdict), finding.check,
               finding.text);
    const std::size_t lines = std::min(finding.items.size(), max_lines);
    for (std::size_t i = 0; i < lines; ++i) fmt::print("{:22}{}\n", "", finding.items[i]);
    if (lines < finding.items.size()) {
      fmt::print("{:22}and {} more (--json lists all)\n", "", finding.items.size() - lines);
    }
    if (failed && !finding.remedy.empty()) fmt::print("{:22}remedy: {}\n", "", finding.remedy);
  }
}

}  // namespace carillon::dataset::check
