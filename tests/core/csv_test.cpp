// CSV files: cells, quotes, blanks, tables.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/csv.hpp"
#include "core/error.hpp"
#include "core/temporary_folder.hpp"

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

TEST(CsvLine, HasQuotesWhereTheyMustBe) {
  EXPECT_EQ(csv_line({"steel", "", "1.5"}), "steel,,1.5\n");
  EXPECT_EQ(csv_line({"left=steel,right=wood"}), "\"left=steel,right=wood\"\n");
  EXPECT_EQ(csv_line({"a \"b\""}), "\"a \"\"b\"\"\"\n");
  EXPECT_EQ(csv_line({"two\nlines"}), "\"two\nlines\"\n");
  EXPECT_EQ(csv_line({"two\rlines"}), "\"two\rlines\"\n");
  EXPECT_EQ(csv_line({" blank"}), "\" blank\"\n");
}

TEST(CsvNumber, IsNothingWhereThereIsNone) {
  EXPECT_EQ(csv_number(1.0 / 3, 4), "0.3333");
  EXPECT_EQ(csv_number(std::nan(""), 4), "");
  EXPECT_EQ(csv_value(nullptr), "");
  EXPECT_EQ(csv_value("a text"), "a text");
  EXPECT_EQ(std::stod(csv_value(0.1 + 0.2)), 0.1 + 0.2);
}

TEST(CsvTable, IsReadAsSpreadsheetsWriteIt) {
  const TemporaryFolder folder;
  const auto path = folder / "a.csv";
  std::ofstream(path) << "\xEF\xBB\xBF"
                      << "# measured\nname, size ,,\r\n\nbar,1,,\r\n#\n\"a,b\",,,2\n";
  const CsvTable table = read_csv(path, '#');
  EXPECT_EQ(table.head.place, path.string() + ":2");
  EXPECT_EQ(table.head.cells, (Cells{"name", "size"}));
  EXPECT_EQ(table.column("size"), 1u);
  EXPECT_FALSE(table.column("weight"));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[0].cells, (Cells{"bar", "1"}));
  EXPECT_EQ(table.rows[1].cells, (Cells{"a,b", "", "", "2"}));
  EXPECT_EQ(read_csv(path, '\0').head.cells, (Cells{"# measured"}));
  std::ofstream(path) << "name\n\"bar\n";
  try {
    read_csv(path, '#');
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.message().rfind(path.string() + ":2: a quote is not closed", 0), 0u);
  }
  EXPECT_THROW(read_csv(folder / "none", '#'), FileError);
}

RC_GTEST_PROP(CsvCells, ComeBackAsTheyWereWritten, ()) {
  const auto cells = *rc::gen::nonEmpty(rc::gen::container<Cells>(
      rc::gen::container<std::string>(rc::gen::elementOf(std::string("a b,\"\t\r")))));
  std::string line = csv_line(cells);
  line.pop_back();
  RC_ASSERT(csv_cells(line) == cells);
}

}  // namespace
}  // namespace carillon::core
