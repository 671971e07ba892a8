#include "core/quantity_list.hpp"

#include <gtest/gtest.h>

#include "core/config.hpp"
#include "core/error.hpp"

namespace carillon::core {
namespace {

std::vector<double> lengths(const std::string& text) {
  return parse_quantities(text, Dimension::length);
}

TEST(QuantityList, AUnitAtTheEndIsForAll) {
  EXPECT_EQ(lengths("5,2,0cm"), (std::vector<double>{0.05, 0.02, 0}));
  EXPECT_EQ(lengths("5, -2 , 1 mm"), (std::vector<double>{0.005, -0.002, 0.001}));
  EXPECT_EQ(lengths("+5,2cm"), (std::vector<double>{0.05, 0.02}));
  EXPECT_EQ(parse_quantities("10,20%", Dimension::none), (std::vector<double>{0.1, 0.2}));
}

TEST(QuantityList, EachMayHaveItsOwn) {
  EXPECT_EQ(lengths("5cm,2mm,0m"), (std::vector<double>{0.05, 0.002, 0}));
  EXPECT_EQ(lengths("0.05,0.02,0"), (std::vector<double>{0.05, 0.02, 0}));
  EXPECT_EQ(lengths("7cm"), std::vector<double>{0.07});
}

TEST(QuantityList, ZeroNeedsNone) {
  EXPECT_EQ(lengths("5cm,0,2cm"), (std::vector<double>{0.05, 0, 0.02}));
  EXPECT_EQ(lengths("5cm,0,0"), (std::vector<double>{0.05, 0, 0}));
  EXPECT_EQ(lengths("0,0.0,5cm"), (std::vector<double>{0, 0, 0.05}));
}

TEST(QuantityList, UnitsOnSomeAreRefusedWithTheRemedy) {
  for (const char* text : {"5cm,2,0", "5,2cm,1", "5cm,2,1cm", "5,2cm,1cm"}) {
    try {
      lengths(text);
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_NE(error.message().find("some of these have a unit and others none"),
                std::string::npos);
      EXPECT_NE(error.hint().find("cm"), std::string::npos);
    }
  }
  try {
    lengths("5cm,2,0");
  } catch (const InputError& error) {
    EXPECT_EQ(error.hint(),
              "one unit at the end is for all, as in 5, 2, 0 cm; or each has its own, as in 5 cm, "
              "2 cm, 0 cm");
  }
}

TEST(QuantityList, WhatIsNoNumberIsToldOfAlone) {
  EXPECT_THROW(lengths("a,2,0cm"), InputError);
  EXPECT_THROW(lengths("5,,0cm"), InputError);
  EXPECT_THROW(lengths(""), InputError);
  EXPECT_THROW(lengths("5,2,0kg"), InputError);
}

TEST(QuantityList, ListsOfAConfigurationAreReadAlike) {
  ConfigNode root = ConfigNode::parse(
      "point: [5, 2, 0 cm]\nrange: [60, 90 mm]\nroom: [[4, 6], 3, 2.5 m]\n"
      "hall: [[400, 600 cm], 3 m, 2.5 m]\nmixed: [5 cm, 2, 1]\n",
      "c.yaml");
  EXPECT_EQ(root.quantities("point", Dimension::length, 3), (std::vector<double>{0.05, 0.02, 0}));
  EXPECT_EQ(root.range("range", Dimension::length), (Range{0.06, 0.09}));
  EXPECT_EQ(root.ranges("room", Dimension::length, 3),
            (std::vector<Range>{{4, 6}, {3, 3}, {2.5, 2.5}}));
  EXPECT_EQ(root.ranges("hall", Dimension::length, 3),
            (std::vector<Range>{{4, 6}, {3, 3}, {2.5, 2.5}}));
  try {
    root.quantities("mixed", Dimension::length, 3);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.message(),
              "c.yaml:5:8: mixed: \"5 cm, 2, 1\": some of these have a unit and others none");
  }
}

}  // namespace
}  // namespace carillon::core
