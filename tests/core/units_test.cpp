#include "core/units.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace carillon::core {
namespace {

const std::vector<Dimension> dimensions = {
    Dimension::none,     Dimension::length,    Dimension::time,      Dimension::frequency,
    Dimension::pressure, Dimension::density,   Dimension::mass,      Dimension::speed,
    Dimension::angle,    Dimension::force,     Dimension::impulse,   Dimension::memory,
    Dimension::level,    Dimension::stiffness, Dimension::resistance};

struct Case {
  const char* text;
  Dimension dimension;
  double value;
};

TEST(ParseQuantity, GivesTheNearestDoubleInSi) {
  // The expected values are the literals of the result, so "12 cm" must be 0.12 to the last bit.
  const Case cases[] = {
      {"0.3", Dimension::length, 0.3},
      {"12 cm", Dimension::length, 0.12},
      {"12cm", Dimension::length, 0.12},
      {"  3.5e1 mm\t", Dimension::length, 0.035},
      {"7 um", Dimension::length, 7e-6},
      {"7 \u00b5m", Dimension::length, 7e-6},
      {"7 \u03bcm", Dimension::length, 7e-6},
      {"1 in", Dimension::length, 0.0254},
      {"-2 km", Dimension::length, -2000},
      {"+2 m", Dimension::length, 2},
      {".5 m", Dimension::length, 0.5},
      {"250 us", Dimension::time, 250e-6},
      {"1.5 h", Dimension::time, 5400},
      {"2 min", Dimension::time, 120},
      {"44.1 kHz", Dimension::frequency, 44100},
      {"72 GPa", Dimension::pressure, 72e9},
      {"2.7 g/cm^3", Dimension::density, 2700},
      {"2.7 g/cm\u00b3", Dimension::density, 2700},
      {"7850 kg / m3", Dimension::density, 7850},
      {"12 mg", Dimension::mass, 12e-6},
      {"36 km/h", Dimension::speed, 10},
      {"180 deg", Dimension::angle, std::numbers::pi},
      {"90\u00b0", Dimension::angle, std::numbers::pi / 2},
      {"5 mN", Dimension::force, 5e-3},
      {"0.2 N s", Dimension::impulse, 0.2},
      {"0.2 N*s", Dimension::impulse, 0.2},
      {"0.2 Ns", Dimension::impulse, 0.2},
      {"200 mN s", Dimension::impulse, 0.2},
      {"5 kN/m", Dimension::stiffness, 5000},
      {"1.5 N/mm", Dimension::stiffness, 1500},
      {"9 N s/m", Dimension::resistance, 9},
      {"9 N*s/m", Dimension::resistance, 9},
      {"9 kg/s", Dimension::resistance, 9},
      {"1.5 GiB", Dimension::memory, 1610612736},
      {"2 GB", Dimension::memory, 2e9},
      {"-6 dB", Dimension::level, -6},
      {"12", Dimension::level, 12},
      {"5 %", Dimension::none, 0.05},
      {"5", Dimension::none, 5},
  };
  for (const Case& one : cases) {
    EXPECT_EQ(parse_quantity(one.text, one.dimension), one.value) << one.text;
  }
}

std::string refusal(const std::string& text, Dimension dimension) {
  try {
    return "accepted as " + std::to_string(parse_quantity(text, dimension));
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(ParseQuantity, RefusesWhatIsNoFiniteNumber) {
  for (const char* text : {"", " ", "cm", "nan", "NaN m", "inf", "-inf", "infinity", ".inf",
                           "1e999", "1e306 km", "--2", "+-2", "0x10", "1,5 m", "1 2 m", "1..2"}) {
    EXPECT_EQ(refusal(text, Dimension::length).find("accepted"), std::string::npos) << text;
  }
}

TEST(ParseQuantity, NamesTheUnitsThatFit) {
  EXPECT_EQ(refusal("12 Hz", Dimension::length),
            "\"12 Hz\" is a frequency; a length is wanted\n"
            "  hint: units of a length: m, cm, mm, um, km, in; a bare number is in m");
  EXPECT_EQ(refusal("12 CM", Dimension::length),
            "\"12 CM\": unknown unit \"CM\"; did you mean \"cm\"?\n"
            "  hint: units of a length: m, cm, mm, um, km, in; a bare number is in m");
  EXPECT_EQ(refusal("3 m", Dimension::none),
            "\"3 m\" is a length; a plain number is wanted\n  hint: leave the unit out");
  EXPECT_EQ(refusal("3 m", Dimension::level),
            "\"3 m\" is a length; a level is wanted\n"
            "  hint: units of a level: dB; a bare number is in dB");
  EXPECT_EQ(refusal("3 %", Dimension::time).substr(0, 45),
            "\"3 %\" is a percentage; a time is wanted\n  hin");
}

TEST(ParseQuantity, ReadsBackEveryNumberWithEveryUnitName) {
  EXPECT_TRUE(rc::check([](double value) {
    RC_PRE(std::isfinite(value));
    const Dimension dimension = *rc::gen::elementOf(dimensions);
    char digits[40];
    std::snprintf(digits, sizeof digits, "%.17g", value);
    RC_ASSERT(parse_quantity(digits, dimension) == value);
    if (dimension != Dimension::none) {
      RC_ASSERT(parse_quantity(std::string(digits) + " " + unit_name(dimension), dimension) ==
                value);
    }
  }));
}

TEST(ParseQuantity, AnyBytesAreANumberOrAnInputError) {
  EXPECT_TRUE(rc::check([] {
    const auto pieces = *rc::gen::container<std::vector<std::string>>(
        rc::gen::elementOf(std::vector<std::string>{"1",
                                                    ".",
                                                    "-",
                                                    "+",
                                                    "e",
                                                    "E9",
                                                    "99999999999999999999",
                                                    "nan",
                                                    "inf",
                                                    " ",
                                                    "cm",
                                                    "m",
                                                    "%",
                                                    "/",
                                                    "^",
                                                    "\xc2",
                                                    "\xb5",
                                                    "\xce\xbc",
                                                    std::string(1, '\0'),
                                                    "\xff",
                                                    "N",
                                                    "s",
                                                    "(",
                                                    "x",
                                                    "\n"}));
    std::string text;
    for (const std::string& piece : pieces) text += piece;
    try {
      RC_ASSERT(std::isfinite(parse_quantity(text, *rc::gen::elementOf(dimensions))));
    } catch (const InputError& error) {
      RC_ASSERT(!error.message().empty());
    }
  }));
}

TEST(UnitName, IsOneThatParses) {
  EXPECT_EQ(unit_name(Dimension::none), "1");
  EXPECT_EQ(unit_name(Dimension::impulse), "N s");
  EXPECT_EQ(unit_name(Dimension::resistance), "N s/m");
  for (Dimension dimension : dimensions) {
    if (dimension == Dimension::none) continue;
    EXPECT_EQ(parse_quantity("3 " + unit_name(dimension), dimension), 3.0);
  }
}

TEST(NearestName, FindsSlipsAndNothingElse) {
  const std::vector<std::string> keys = {"length", "thickness", "max_frequency", "min_frequency"};
  EXPECT_EQ(nearest_name("lenght", keys), "length");
  EXPECT_EQ(nearest_name("Length", keys), "length");
  EXPECT_EQ(nearest_name("max-frequency", keys), "max_frequency");
  EXPECT_EQ(nearest_name("thicknes", keys), "thickness");
  EXPECT_EQ(nearest_name("volume", keys), "");
  EXPECT_EQ(nearest_name("", keys), "");
  EXPECT_EQ(nearest_name("length", {}), "");
}

TEST(NearestName, AnExactNameIsNearest) {
  EXPECT_TRUE(rc::check([](const std::vector<std::string>& names) {
    RC_PRE(!names.empty());
    const std::string word = *rc::gen::elementOf(names);
    RC_PRE(!word.empty());
    const std::string found = nearest_name(word, names);
    RC_ASSERT(found.size() == word.size());
  }));
}

}  // namespace
}  // namespace carillon::core
