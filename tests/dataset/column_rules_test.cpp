// The columns of a dataset: one list, which docs/format.md shows and `carillon check` goes by.
#include "dataset/check/detail/column_rules.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "core/files.hpp"
#include "scene/columns.hpp"

namespace carillon::dataset {
namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

std::string table_of_columns() {
  std::string table =
      "| column | type | row | unit | when | meaning |\n| --- | --- | --- | --- | --- | --- |\n";
  for (const core::ColumnRule& rule : scene::columns()) {
    table += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", rule.name,
                         *rule.type == '\0' ? "float32, int16" : rule.type,
                         replaced(rule.inner, ",", ", "), replaced(rule.units, "|", " or "),
                         replaced(replaced(rule.when, "struck:", "struck, "), "|", " or "),
                         rule.meaning);
  }
  return table;
}

TEST(ColumnRules, AreTheTableOfTheDocument) {
  const std::string document = core::read_file(CARILLON_FORMAT_DOC);
  EXPECT_NE(document.find(table_of_columns()), std::string::npos)
      << "docs/format.md should have this table:\n"
      << table_of_columns();
}

TEST(ColumnRules, NameEachColumnOnce) {
  std::set<std::string> names;
  for (const core::ColumnRule& rule : scene::columns()) {
    EXPECT_TRUE(names.insert(rule.name).second) << rule.name;
  }
}

TEST(ColumnRules, TellWhatIsWrong) {
  const configuration::BuildConfig config = configuration::read_build_config(
      "objects:\n  - shape: bar\n    materials: [steel]\naudio: {seconds: 0.1}\n", "test.yaml", {});
  const auto rule = [](const char* name) { return core::find_rule(scene::columns(), name); };
  const core::ColumnRule& audio = *rule("audio");
  EXPECT_EQ(check::break_of(audio, config, "float32", {4410}, "m/s"), "");
  EXPECT_EQ(check::break_of(audio, config, "int16", {4410}, "m/s"), "holds int16, not float32");
  EXPECT_EQ(check::break_of(audio, config, "float32", {2, 4410}, "m/s"),
            "a row is [2, 4410], not [4410]");
  EXPECT_EQ(check::break_of(audio, config, "float32", {4410}, "V"), "is in \"V\", not m/s or Pa");
  EXPECT_EQ(check::break_of(*rule("support_position"), config, "float64", {4, 3}, "m"), "");
  EXPECT_NE(check::break_of(*rule("support_position"), config, "float64", {4}, "m"), "");
  EXPECT_STREQ(rule("alpha12")->name, "alpha");
  EXPECT_EQ(rule("alphabet"), nullptr);
  EXPECT_EQ(check::expected(audio, config), true);
  EXPECT_EQ(check::expected(*rule("room"), config), false);
  EXPECT_EQ(check::expected(*rule("recording_shift"), config), std::nullopt);
}

}  // namespace
}  // namespace carillon::dataset
