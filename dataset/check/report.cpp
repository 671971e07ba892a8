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

std::string findings_text(const std::vector<Finding>& findings) {
  std::string text;
  constexpr std::size_t max_lines = 5;
  for (const Finding& finding : findings) {
    const bool failed = finding.verdict == Verdict::fail;
    text += fmt::format("  {}  {:<13} {}\n", failed ? "FAIL" : name_of(finding.verdict),
                        finding.check, finding.text);
    const std::size_t lines = std::min(finding.items.size(), max_lines);
    for (std::size_t i = 0; i < lines; ++i) text += fmt::format("{:22}{}\n", "", finding.items[i]);
    if (lines < finding.items.size()) {
      text +=
          fmt::format("{:22}and {} more (--json lists all)\n", "", finding.items.size() - lines);
    }
    if (failed && !finding.remedy.empty())
      text += fmt::format("{:22}remedy: {}\n", "", finding.remedy);
  }
  return text;
}

}  // namespace carillon::dataset::check
