// The columns that `carillon check` expects are those of docs/format.md.
#include "dataset/check/column_rules.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <sstream>

#include "core/files.hpp"

namespace carillon::dataset {
namespace {

/// First cells of the tables between two headings, split at their commas.
std::set<std::string> documented() {
  const std::string document = core::read_file(CARILLON_FORMAT_DOC);
  const std::size_t begin = document.find("## index.h5 and shards");
  std::istringstream lines(document.substr(begin, document.find("`shapes/` in the index") - begin));
  std::set<std::string> names;
  const std::regex quoted("`([a-z0-9_]+)`");
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| `")) continue;
    const std::string cell = line.substr(0, line.find(" | "));
    for (std::sregex_iterator at(cell.begin(), cell.end(), quoted), end; at != end; ++at) {
      const std::string name = (*at)[1];
      names.insert(name.starts_with("alpha") ? "alpha" : name);
    }
  }
  names.erase("shape_index");  // of the index alone
  return names;
}

TEST(ColumnRules, AreThoseOfTheDocument) {
  std::set<std::string> rules;
  for (const check::ColumnRule& rule : check::column_rules()) rules.insert(rule.name);
  EXPECT_EQ(rules, documented());
}

TEST(ColumnRules, TellWhatIsWrong) {
  const configuration::BuildConfig config = configuration::read_build_config(
      "objects:\n  - shape: bar\n    materials: [steel]\naudio: {seconds: 0.1}\n", "test.yaml", {});
  const check::ColumnRule& audio = *check::find_rule("audio");
  EXPECT_EQ(check::break_of(audio, config, "float32", {4410}, "m/s"), "");
  EXPECT_EQ(check::break_of(audio, config, "int16", {4410}, "m/s"), "holds int16, not float32");
  EXPECT_EQ(check::break_of(audio, config, "float32", {2, 4410}, "m/s"),
            "a row is [2, 4410], not [4410]");
  EXPECT_EQ(check::break_of(audio, config, "float32", {4410}, "V"), "is in \"V\", not m/s or Pa");
  EXPECT_EQ(check::break_of(*check::find_rule("support_position"), config, "float64", {4, 3}, "m"),
            "");
  EXPECT_NE(check::break_of(*check::find_rule("support_position"), config, "float64", {4}, "m"),
            "");
  EXPECT_STREQ(check::find_rule("alpha12")->name, "alpha");
  EXPECT_EQ(check::find_rule("alphabet"), nullptr);
  EXPECT_EQ(check::expected(audio, config), true);
  EXPECT_EQ(check::expected(*check::find_rule("room"), config), false);
  EXPECT_EQ(check::expected(*check::find_rule("recording_shift"), config), std::nullopt);
}

}  // namespace
}  // namespace carillon::dataset
