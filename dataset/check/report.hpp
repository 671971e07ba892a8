#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace carillon::dataset::check {

enum class Verdict {
  pass,
  note,  ///< right, and yet worth knowing
  fail,
};

/// The outcome of one check of a dataset.
struct Finding {
  std::string check;  ///< its name
  Verdict verdict = Verdict::pass;
  std::string text;                ///< what was found, one line
  std::string remedy;              ///< of what failed
  std::vector<std::string> items;  ///< what failed or is noted, one line each
};

/// A check that fails when there are items, and passes otherwise.
Finding judged(const std::string& check, std::vector<std::string> items, const std::string& passed,
               const std::string& failed, const std::string& remedy);

std::string name_of(Verdict verdict);
nlohmann::json to_json(const Finding& finding);
/// Whether no check failed.
bool all_pass(const std::vector<Finding>& findings);
/// The table for a person; of long lists the first few lines.
std::string findings_text(const std::vector<Finding>& findings);

}  // namespace carillon::dataset::check
