#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "core/config.hpp"
#include "core/error.hpp"

namespace carillon::core {
namespace {

using Read = std::function<void(ConfigNode&)>;

/// The whole message (with its hint) of the ConfigError that reading ends in.
std::string refusal(
    const std::string& text, const Read& read = [](ConfigNode&) {}) {
  try {
    ConfigNode root = ConfigNode::parse(text, "c.yaml");
    read(root);
    return "accepted";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

Read length(const std::string& key) {
  return [key](ConfigNode& root) { root.quantity(key, Dimension::length); };
}

TEST(ConfigErrors, AnUnknownKeyNamesTheNearest) {
  const std::string text =
      "seed: 1\n"
      "objects:\n"
      "  - family: cup\n"
      "    lenght: 12 cm\n";
  const auto read = [](ConfigNode& root) {
    root.integer("seed", 0, 9);
    for (ConfigNode& one : root.children("objects")) {
      one.text("family");
      one.quantity("length", Dimension::length, 0.1);
    }
    root.finish();
  };
  EXPECT_EQ(refusal(text, read),
            "c.yaml:4:5: objects[0].lenght: unknown key; did you mean \"length\"?");
}

TEST(ConfigErrors, SignsOfQuantitiesAreHeldWhereTheyAreRead) {
  const auto positive = [](ConfigNode& root) { root.positive("x", Dimension::length); };
  const auto not_negative = [](ConfigNode& root) { root.not_negative("x", Dimension::length); };
  EXPECT_EQ(refusal("x: 1 mm\n", positive), "accepted");
  EXPECT_EQ(refusal("x: 0 mm\n", positive), "c.yaml:1:4: x: must be positive");
  EXPECT_EQ(refusal("x: 0 mm\n", not_negative), "accepted");
  EXPECT_EQ(refusal("x: -1 mm\n", not_negative), "c.yaml:1:4: x: must not be negative");
  EXPECT_EQ(
      refusal("{}\n",
              [](ConfigNode& root) { EXPECT_EQ(root.positive("x", Dimension::length, 2.0), 2); }),
      "accepted");
}

TEST(ConfigErrors, AnUnknownKeyLikeNoOtherListsTheKnown) {
  const auto read = [](ConfigNode& root) {
    root.flag("verbose", false);
    root.child("audio");
    root.finish();
  };
  EXPECT_EQ(refusal("colour: red\n", read),
            "c.yaml:1:1: colour: unknown key\n  hint: known keys: verbose, audio");
  EXPECT_EQ(refusal("audio:\n  x: 1\n", read),
            "c.yaml:2:3: audio.x: unknown key\n  hint: no key is known here");
}

TEST(ConfigErrors, AKeyThatWasOnlyLookedForHasNoEffect) {
  const auto read = [](ConfigNode& root) {
    if (!root.has("mesh")) root.quantity("length", Dimension::length, 1.0);
    if (root.has("mesh")) root.text("mesh");
    root.has("length");
    root.finish();
  };
  EXPECT_EQ(refusal("mesh: a.obj\nlength: 1 m\n", read),
            "c.yaml:2:1: length: has no effect beside the other keys\n  hint: remove it");
  EXPECT_EQ(refusal("length: 1 m\n", read), "accepted");
}

TEST(ConfigErrors, AMissingKeyNamesItsUnitAndTheLikelySlip) {
  EXPECT_EQ(refusal("a: 1\n", length("length")),
            "c.yaml:1:1: length: missing; a value in m is wanted");
  EXPECT_EQ(refusal("a: 1\nlenght: 2\n", length("length")),
            "c.yaml:1:1: length: missing; a value in m is wanted\n"
            "  hint: is \"lenght\" (c.yaml:2:1) meant for it?");
  EXPECT_EQ(refusal("objects:\n- x: 1\n",
                    [](ConfigNode& root) { root.children("objects")[0].text("family"); }),
            "c.yaml:2:3: objects[0].family: missing; a text is wanted");
  EXPECT_EQ(
      refusal("a:\n  b: 1\n",
              [](ConfigNode& root) { root.child("a").child("c").quantity("d", Dimension::time); }),
      "c.yaml:2:3: a.c.d: missing; a value in s is wanted");
}

TEST(ConfigErrors, AWrongUnitOrNumberNamesWhatFits) {
  EXPECT_EQ(refusal("x: 12 Hz\n", length("x")),
            "c.yaml:1:4: x: \"12 Hz\" is a frequency; a length is wanted\n"
            "  hint: units of a length: m, cm, mm, um, km, in; a bare number is in m");
  for (const char* text :
       {"x: long", "x: .nan", "x: .inf", "x: -inf", "x: nan", "x: ''", "x: 1e400", "x: true"}) {
    const std::string answer = refusal(text, length("x"));
    EXPECT_EQ(answer.substr(0, 14), "c.yaml:1:4: x:") << answer;
  }
}

TEST(ConfigErrors, AWrongTypeSaysWhatStandsThere) {
  EXPECT_EQ(refusal("x: [1, 2]\n", length("x")),
            "c.yaml:1:4: x: a value in m is wanted, not a list");
  EXPECT_EQ(refusal("x:\n  y: 1\n", length("x")),
            "c.yaml:2:3: x: a value in m is wanted, not a mapping");
  EXPECT_EQ(refusal("x:\n", length("x")), "c.yaml:1:1: x: has no value; a value in m is wanted");
  EXPECT_EQ(refusal("x: ~\n", [](ConfigNode& root) { root.flag("x", true); }),
            "c.yaml:1:1: x: has no value; true or false is wanted\n"
            "  hint: leave the key out for its default");
  EXPECT_EQ(refusal("x: 5\n", [](ConfigNode& root) { root.child("x"); }),
            "c.yaml:1:4: x: a mapping of keys is wanted\n"
            "  hint: write its keys indented below it");
  EXPECT_EQ(refusal("x: {a: 1}\n", [](ConfigNode& root) { root.children("x"); }),
            "c.yaml:1:4: x: a list of mappings is wanted\n"
            "  hint: begin each element with \"- \"");
  EXPECT_EQ(refusal("x: [{a: 1}, 7]\n", [](ConfigNode& root) { root.children("x"); }),
            "c.yaml:1:13: x[1]: a mapping of keys is wanted");
  EXPECT_EQ(refusal("x: [a, [b]]\n", [](ConfigNode& root) { root.texts("x"); }),
            "c.yaml:1:8: x[1]: a text is wanted, not a list");
  EXPECT_EQ(refusal("x: [a, ~]\n", [](ConfigNode& root) { root.texts("x"); }),
            "c.yaml:1:8: x[1]: a text is wanted, not nothing");
  EXPECT_EQ(refusal("x: maybe\n", [](ConfigNode& root) { root.flag("x", true); }),
            "c.yaml:1:4: x: true or false is wanted, not \"maybe\"");
}

TEST(ConfigErrors, RangesAndListsAreChecked) {
  const auto range = [](ConfigNode& root) { root.range("x", Dimension::length); };
  EXPECT_EQ(refusal("x: [2 cm, 1 cm]\n", range),
            "c.yaml:1:4: x: the range begins at 0.02 and ends below it, at 0.01\n"
            "  hint: write [low, high]");
  EXPECT_EQ(refusal("x: [1, 2, 3]\n", range),
            "c.yaml:1:4: x: a value in m or a list [low, high] is wanted, not a list of 3");
  EXPECT_EQ(refusal("x: [1 cm, 3 s]\n", range).substr(0, 32), "c.yaml:1:11: x[1]: \"3 s\" is a ti");
  EXPECT_EQ(refusal("x: {low: 1}\n", range),
            "c.yaml:1:4: x: a value in m or a list [low, high] is wanted, not a mapping");
  const auto point = [](ConfigNode& root) { root.quantities("x", Dimension::none, 3); };
  EXPECT_EQ(refusal("x: [1, 2]\n", point), "c.yaml:1:4: x: a list of 3 values is wanted, not of 2");
  EXPECT_EQ(refusal("x: 1\n", point),
            "c.yaml:1:4: x: a list of 3 values is wanted\n  hint: write [a, b, ...]");
}

TEST(ConfigErrors, IntegersAreWholeAndInRange) {
  const auto read = [](ConfigNode& root) { root.integer("n", 1, 300); };
  EXPECT_EQ(refusal("n: 0\n", read),
            "c.yaml:1:4: n: 0 is out of range; a whole number from 1 to 300 is wanted");
  EXPECT_EQ(refusal("n: 301\n", read).substr(0, 19), "c.yaml:1:4: n: 301 ");
  EXPECT_EQ(refusal("n: 99999999999999999999\n", read),
            "c.yaml:1:4: n: 99999999999999999999 is out of range; a whole number from 1 to 300 is "
            "wanted");
  EXPECT_NE(refusal("n: 1e400\n", read).find("out of range"), std::string::npos);
  for (const char* text :
       {"n: 2.5", "n: two", "n: 3 m", "n: nan", "n: inf", "n: 0x10", "n: ''", "n: +", "n: '+-5'"}) {
    EXPECT_NE(refusal(text, read).find("a whole number from 1 to 300 is wanted, not"),
              std::string::npos)
        << text << " -> " << refusal(text, read);
  }
}

TEST(ConfigErrors, AChoiceNamesTheNearestAndTheRest) {
  const auto read = [](ConfigNode& root) { root.choice("m", {"steel", "glass"}); };
  EXPECT_EQ(refusal("m: stell\n", read),
            "c.yaml:1:4: m: unknown value \"stell\"; did you mean \"steel\"?\n"
            "  hint: one of steel, glass");
  EXPECT_EQ(refusal("m: rubber\n", read),
            "c.yaml:1:4: m: unknown value \"rubber\"\n  hint: one of steel, glass");
}

TEST(ConfigErrors, AKeyMayStandOnlyOnce) {
  EXPECT_EQ(refusal("a:\n  seed: 1\n  b: 2\n  seed: 2\n"),
            "c.yaml:4:3: a.seed: the key stands twice; first at line 2, column 3");
  EXPECT_EQ(refusal("o: [{x: 1, x: 2}]\n"),
            "c.yaml:1:12: o[0].x: the key stands twice; first at line 1, column 6");
}

TEST(ConfigErrors, MalformedYamlPointsAtThePlace) {
  EXPECT_EQ(refusal("a: [1, 2\nb: 3\n").substr(0, 26), "c.yaml:2:2: malformed YAML");
  EXPECT_EQ(refusal("a: 1\nb: \"open \\\"\nc: 2\n").substr(0, 44),
            "c.yaml:2:4: b: malformed YAML: the quote is ");
  EXPECT_EQ(refusal("a: 'it''s open\n").substr(0, 44),
            "c.yaml:1:4: a: malformed YAML: the quote is ");
  EXPECT_EQ(refusal("a: *nowhere\n").substr(0, 27), "c.yaml:1:4: malformed YAML:");
  const std::string tab = refusal("audio:\n\tseconds: 1\n");
  EXPECT_EQ(tab.substr(0, 9), "c.yaml:2:") << tab;
  EXPECT_NE(tab.find("hint: YAML forbids tabs in indentation; use spaces"), std::string::npos)
      << tab;
}

TEST(ConfigErrors, OnlyUtf8TextIsRead) {
  EXPECT_EQ(refusal("a: 1\nname: caf\xe9\n"),
            "c.yaml:2:10: a byte (0xe9) that is not UTF-8\n  hint: save the file as UTF-8 text");
  // yaml-cpp would take 0x04 for the end of the text.
  EXPECT_EQ(refusal("a: 1\n\x04"
                    "b: 2\n")
                .substr(0, 43),
            "c.yaml:2:1: a control character (0x04)\n  hi");
  EXPECT_EQ(refusal(std::string("a\0:\0 \0", 6)).substr(0, 38),
            "c.yaml:1:2: a control character (0x00)");
  EXPECT_NE(refusal("a: \xf0\x9f\x94").find("not UTF-8"), std::string::npos);
}

TEST(ConfigErrors, PlacesCountCharactersWhateverTheLineEnds) {
  EXPECT_EQ(refusal("{\"gr\u00f6\u00dfe\": 1, x: y}\r\n", length("x")).substr(0, 17),
            "c.yaml:1:17: x: \"");
  EXPECT_EQ(refusal("\xef\xbb\xbf"
                    "a: 'b'\r\nx: 'long'\r\n",
                    length("x"))
                .substr(0, 16),
            "c.yaml:2:4: x: \"");
}

TEST(ConfigErrors, TextAfterTheDocumentIsNotPassedOver) {
  // Read node by node, the parser would end before the stray bracket, and ",..." would never end.
  EXPECT_EQ(refusal("a: 1\n}\n").substr(0, 26), "c.yaml:2:1: malformed YAML");
  EXPECT_EQ(refusal(",a: 1\n").substr(0, 26), "c.yaml:1:1: malformed YAML");
  EXPECT_EQ(refusal("a: 1\n---\nb: 2\n"),
            "c.yaml:2:1: a second YAML document begins; a configuration is one document");
}

TEST(ConfigErrors, TheRootIsAMapping) {
  for (const char* text : {"- a\n- b\n", "just a text\n", "[]", "5"}) {
    EXPECT_NE(refusal(text).find("a configuration is a mapping of keys"), std::string::npos);
  }
}

TEST(ConfigErrors, KeysAreTexts) {
  EXPECT_EQ(refusal("? [a]\n: b\n"), "c.yaml:1:3: a key must be a text");
  EXPECT_EQ(refusal("x: {~: 1}\n"), "c.yaml:1:5: x: a key must be a text");
}

TEST(ConfigErrors, AKeyWithoutANameIsUnknown) {
  ConfigNode root = ConfigNode::parse("\"\": [{a: 1}]\n", "test.yaml");
  EXPECT_EQ(root.children("").size(), 1u);
  EXPECT_EQ(root.children("").size(), 1u);
  EXPECT_THROW(root.finish(), ConfigError);
}

TEST(ConfigErrors, NestingAndAliasesAreBounded) {
  EXPECT_NE(refusal("a: " + std::string(10000, '[')).find("nested more than 64 deep"),
            std::string::npos);
  std::string laughs = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 20; ++i) {
    laughs += fmt::format("a{0}: &a{0} [*a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}]\n", i, i - 1);
  }
  EXPECT_NE(refusal(laughs).find("more than 1000000 values"), std::string::npos);
  EXPECT_NE(refusal("a: &a [1, *a]\n").find("inside its own anchor"), std::string::npos);
  EXPECT_NE(refusal("a: {<<: 5}\n").find("merges a mapping"), std::string::npos);
}

TEST(ConfigErrors, FailPointsAtTheValueOrTheMapping) {
  EXPECT_EQ(refusal("a:\n  mesh: x.obj\n",
                    [](ConfigNode& root) { root.child("a").fail("mesh", "no such file", "look"); }),
            "c.yaml:2:9: a.mesh: no such file\n  hint: look");
  EXPECT_EQ(refusal("a:\n  mesh: x.obj\n",
                    [](ConfigNode& root) { root.child("a").fail("", "needs a shape"); }),
            "c.yaml:2:3: a: needs a shape");
  EXPECT_EQ(refusal("a: 1\n", [](ConfigNode& root) { root.fail("", "is too much"); }),
            "c.yaml:1:1: is too much");
}

}  // namespace
}  // namespace carillon::core
