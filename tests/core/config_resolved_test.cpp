#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "core/config.hpp"
#include "core/config_text.hpp"

namespace carillon::core {
namespace {

std::string read_all(ConfigNode root) {
  root.quantity("length", Dimension::length);
  root.range("wall", Dimension::length, Range{0.001, 0.003});
  ConfigNode audio = root.child("audio");
  audio.quantity("rate", Dimension::frequency, 44100.0);
  audio.choice("type", {"float32", "int16"}, "float32");
  root.child("room").flag("enabled", false);
  for (ConfigNode& one : root.children("objects")) {
    one.text("family");
    one.integer("count", 0, 99, 1);
    one.quantities("at", Dimension::none, 3, std::vector<double>{0, 0, 1});
  }
  root.texts("names", std::vector<std::string>{});
  root.children("none");
  root.child("empty");
  root.finish();
  return root.resolved();
}

TEST(ConfigResolved, HoldsEveryAnswerInSiInTheOrderOfAsking) {
  const std::string text =
      "objects:\n- {family: cup, count: 2}\n- family: 'my bar'\nnames: [a, 'yes', 12]\n"
      "length: 12 cm\n";
  EXPECT_EQ(read_all(ConfigNode::parse(text, "c.yaml")),
            "length: 0.12  # m\n"
            "wall: [0.001, 0.003]  # m\n"
            "audio:\n"
            "  rate: 44100  # Hz\n"
            "  type: float32\n"
            "room:\n"
            "  enabled: false\n"
            "objects:\n"
            "  - family: cup\n"
            "    count: 2\n"
            "    at: [0, 0, 1]\n"
            "  - family: \"my bar\"\n"
            "    count: 1\n"
            "    at: [0, 0, 1]\n"
            "names: [a, \"yes\", \"12\"]\n"
            "none: []\n"
            "empty: {}\n");
}

TEST(ConfigResolved, ReadAgainItResolvesToItself) {
  const std::string once =
      read_all(ConfigNode::parse("length: 3.3 mm\nobjects: [{family: \"a\\n: b\"}]\n", "c.yaml"));
  EXPECT_EQ(read_all(ConfigNode::parse(once, "c.yaml")), once);
}

TEST(ConfigResolved, OverridesAreInIt) {
  const std::string text =
      read_all(ConfigNode::parse("length: 1\n", "c.yaml", {"length=2 cm", "audio.rate=8 kHz"}));
  EXPECT_NE(text.find("length: 0.02  # m\n"), std::string::npos);
  EXPECT_NE(text.find("rate: 8000  # Hz\n"), std::string::npos);
}

TEST(ConfigResolved, NothingAskedIsAnEmptyMapping) {
  EXPECT_EQ(ConfigNode::parse("", "c.yaml").resolved(), "{}\n");
}

TEST(ConfigResolved, AskingAgainChangesNothing) {
  ConfigNode root = ConfigNode::parse("a: {b: 1}\nc: 2\n", "c.yaml");
  root.child("a").quantity("b", Dimension::none);
  root.quantity("c", Dimension::mass);
  const std::string once = root.resolved();
  root.has("a");
  root.child("a").quantity("b", Dimension::none);
  root.quantity("c", Dimension::mass);
  EXPECT_EQ(root.resolved(), once);
}

TEST(YamlNumber, ReadsBackAsTheSameDoubleAndAsANumberEverywhere) {
  EXPECT_EQ(yaml_number(0.1), "0.1");
  EXPECT_EQ(yaml_number(20000), "20000");
  EXPECT_EQ(yaml_number(1e-5), "1.0e-05");
  EXPECT_EQ(yaml_number(2.1e11), "210000000000");
  EXPECT_EQ(yaml_number(-1e300), "-1.0e+300");
  EXPECT_EQ(yaml_number(std::numeric_limits<double>::infinity()), ".inf");
  EXPECT_EQ(yaml_number(-std::numeric_limits<double>::infinity()), "-.inf");
  EXPECT_EQ(yaml_number(std::nan("")), ".nan");
  EXPECT_TRUE(rc::check([](std::uint64_t bits) {
    double value = 0;
    static_assert(sizeof value == sizeof bits);
    std::memcpy(&value, &bits, sizeof value);
    RC_PRE(std::isfinite(value));
    const double back = parse_quantity(yaml_number(value), Dimension::none);
    RC_ASSERT(std::memcmp(&back, &value, sizeof value) == 0);
  }));
}

TEST(YamlText, ReadsBackAsTheSameTextAsKeyValueAndElement) {
  EXPECT_EQ(yaml_text("meshes/cup.obj"), "meshes/cup.obj");
  for (const char* word :
       {"true", "No", "null", "~", "", "-", "3", "a: b", "#x", "- x", "0x1", "y"}) {
    EXPECT_EQ(yaml_text(word).front(), '"') << word;
  }
  EXPECT_TRUE(rc::check([] {
    const auto pieces =
        *rc::gen::container<std::vector<std::string>>(rc::gen::elementOf(std::vector<std::string>{
            "a",  "Z",  "9",  " ",      ":",      "#",      "-",          "'",   "\"",
            "\\", "\n", "\t", "\r",     "\x01",   "\x7f",   "{",          "]",   ",",
            "&",  "*",  "%",  "\u00e9", "\u2028", "\u0085", "\U0001d11e", "x: ", " #"}));
    std::string text;
    for (const std::string& piece : pieces) text += piece;
    const std::string quoted = yaml_text(text);
    const YAML::Node node =
        YAML::Load("k: " + quoted + "\nl: [" + quoted + "]\nm:\n  " + quoted + ": 1\n");
    RC_ASSERT(node["k"].Scalar() == text);
    RC_ASSERT(node["l"][0].Scalar() == text);
    RC_ASSERT(node["m"].begin()->first.Scalar() == text);
  }));
}

}  // namespace
}  // namespace carillon::core
