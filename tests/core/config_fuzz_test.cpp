#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <string>
#include <vector>

#include "core/config.hpp"
#include "core/error.hpp"

namespace carillon::core {
namespace {

/// Asks for everything in every way; only a ConfigError may come out.
void read_all(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    ConfigNode root = ConfigNode::parse(text, "fuzz.yaml", overrides);
    for (const std::string& key : root.keys()) {
      const auto survive = [&](const auto& ask) {
        try {
          ask();
        } catch (const ConfigError& error) {
          RC_ASSERT(!error.message().empty());
        }
      };
      survive([&] { root.quantity(key, Dimension::length); });
      survive([&] { root.range(key, Dimension::frequency); });
      survive([&] { root.quantities(key, Dimension::none, 3); });
      survive([&] { root.integer(key, -5, 5); });
      survive([&] { root.flag(key, true); });
      survive([&] { root.text(key); });
      survive([&] { root.texts(key); });
      survive([&] { root.choice(key, {"steel", "glass"}); });
      survive([&] { root.child(key).finish(); });
      survive([&] {
        for (ConfigNode& one : root.children(key)) one.text("family");
      });
      survive([&] { root.finish(); });
      root.resolved();
    }
  } catch (const ConfigError& error) {
    const bool placed =
        error.message().starts_with("fuzz.yaml:") || error.message().starts_with("--set ");
    RC_ASSERT(placed);
  }
}

const std::vector<std::string> documents = {
    "seed: 7\naudio:\n  seconds: 1 s\n  rate: 44.1 kHz\nobjects:\n  - family: cup\n    size: [5 "
    "cm, "
    "9 cm]\n  - {family: bar, size: 0.1}\n",
    "base: &base {family: cup, wall: 3 mm}\nobjects:\n- <<: *base\n  count: 3\n- *base\n",
    "text: |\n  two\n  lines\nfolded: >-\n  a\n  b\nquoted: \"a\\n\\x41\"\nnull: ~\n",
    "? complex\n: value\n--- \nsecond: 1\n...\n",
    "%YAML 1.2\n---\n!!map {a: !!str b, 'it''s': [1, 2, [3, {x: y}]]}\n",
};

const std::vector<std::string> pieces = {"&a ",
                                         "*a",
                                         "<<: ",
                                         "- ",
                                         ": ",
                                         "? ",
                                         "[",
                                         "]",
                                         "{",
                                         "}",
                                         "|\n",
                                         ">+2\n",
                                         "!x ",
                                         "!<",
                                         "%TAG",
                                         "---",
                                         "...",
                                         "\t",
                                         "\"",
                                         "'",
                                         "#",
                                         "\n",
                                         "\n  ",
                                         ",",
                                         "@",
                                         "`",
                                         "\\x4",
                                         "~",
                                         "1e999",
                                         "nan",
                                         ".inf",
                                         "0x1p",
                                         "1 cm",
                                         "\xff\xfe",
                                         "\xef\xbb\xbf",
                                         std::string(1, '\0'),
                                         "\xc3",
                                         "\x04",
                                         "\r",
                                         "!",
                                         "&",
                                         "*",
                                         "a",
                                         "key: 1\n",
                                         " "};

rc::Gen<std::string> mutated_document() {
  return rc::gen::exec([] {
    std::string text = *rc::gen::elementOf(documents);
    const int edits = *rc::gen::inRange(1, 8);
    for (int i = 0; i < edits; ++i) {
      const auto at = *rc::gen::inRange<std::size_t>(0, text.size() + 1);
      switch (*rc::gen::inRange(0, 4)) {
        case 0:
          text.insert(at, *rc::gen::elementOf(pieces));
          break;
        case 1:
          text.erase(at, *rc::gen::inRange<std::size_t>(1, 12));
          break;
        case 2:
          text.insert(at, text.substr(*rc::gen::inRange<std::size_t>(0, text.size() + 1), 20));
          break;
        default:
          if (at < text.size()) text[at] = static_cast<char>(*rc::gen::inRange(0, 256));
      }
    }
    return text;
  });
}

TEST(ConfigFuzz, AMutatedDocumentIsReadOrRefused) {
  EXPECT_TRUE(rc::check([] { read_all(*mutated_document()); }));
}

TEST(ConfigFuzz, ASoupOfYamlSignsIsReadOrRefused) {
  EXPECT_TRUE(rc::check([] {
    std::string text;
    for (const std::string& piece :
         *rc::gen::container<std::vector<std::string>>(rc::gen::elementOf(pieces))) {
      text += piece;
    }
    read_all(text);
  }));
}

TEST(ConfigFuzz, AMutatedOverrideIsTakenOrRefused) {
  EXPECT_TRUE(rc::check([] {
    std::string assignment = *rc::gen::elementOf(std::vector<std::string>{
        "audio.seconds=2", "objects[0].family=bar", "objects[2]={family: x}", "a.b[0][1].c=[1]"});
    const auto at = *rc::gen::inRange<std::size_t>(0, assignment.size() + 1);
    assignment.insert(at, *rc::gen::elementOf(std::vector<std::string>{
                              "[", "]", ".", "=", "[-1]", "[99999999999999999999]", "[1]", "\n",
                              "{", "*a", "\t", "--- ", std::string(1, '\0')}));
    read_all(documents[0], {assignment});
  }));
}

}  // namespace
}  // namespace carillon::core
