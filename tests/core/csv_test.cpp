// Lines of CSV files: cells, quotes, blanks.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "core/csv.hpp"
#include "core/error.hpp"

namespace carillon::core {
namespace {

using Cells = std::vector<std::string>;

TEST(CsvCells, AreBetweenCommasWithoutTheirBlanks) {
  EXPECT_EQ(csv_cells("a, b ,c\r"), (Cells{"a", "b", "c"}));
  EXPECT_EQ(csv_cells(""), (Cells{""}));
  EXPECT_EQ(csv_cells("a,,"), (Cells{"a", "", ""}));
}

TEST(CsvCells, MayHoldCommasQuotesAndBlanksWithinQuotes) {
  EXPECT_EQ(csv_cells("\"a, b\",c"), (Cells{"a, b", "c"}));
  EXPECT_EQ(csv_cells("\"say \"\"ah\"\"\", \" x \" \r"), (Cells{"say \"ah\"", " x "}));
  EXPECT_EQ(csv_cells("5\" disc,b"), (Cells{"5\" disc", "b"}));
  EXPECT_EQ(csv_cells("\"\",a"), (Cells{"", "a"}));
  EXPECT_THROW(csv_cells("a,\"b,c"), InputError);
}

TEST(CsvCell, IsInQuotesWhereItMustBe) {
  EXPECT_EQ(csv_cell("steel"), "steel");
  EXPECT_EQ(csv_cell(""), "");
  EXPECT_EQ(csv_cell("left=steel,right=wood"), "\"left=steel,right=wood\"");
  EXPECT_EQ(csv_cell("a \"b\""), "\"a \"\"b\"\"\"");
  EXPECT_EQ(csv_cell("two\nlines"), "\"two\nlines\"");
  EXPECT_EQ(csv_cell("two\rlines"), "\"two\rlines\"");
  EXPECT_EQ(csv_cell(" blank"), "\" blank\"");
}

RC_GTEST_PROP(CsvCells, ComeBackAsTheyWereWritten, ()) {
  const auto cells = *rc::gen::nonEmpty(rc::gen::container<Cells>(
      rc::gen::container<std::string>(rc::gen::elementOf(std::string("a b,\"\t\r")))));
  std::string line;
  for (const std::string& cell : cells) {
    if (&cell != &cells.front()) line += ',';
    line += csv_cell(cell);
  }
  RC_ASSERT(csv_cells(line) == cells);
}

}  // namespace
}  // namespace carillon::core
