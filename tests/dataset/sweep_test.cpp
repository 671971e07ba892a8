#include "dataset/sweep/sweep.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.hpp"
#include "dataset/configuration/configuration.hpp"
#include "dataset/sweep/detail/values.hpp"

namespace carillon::dataset {
namespace {

sweep::Sweep sweep_of(const std::string& lines, const std::vector<std::string>& overrides = {}) {
  const auto sweep = sweep::read_sweep("name: x\nsweep:\n" + lines, "s.yaml", overrides);
  EXPECT_TRUE(sweep.has_value());
  return sweep.value_or(sweep::Sweep{});
}

std::vector<std::string> folders(const sweep::Sweep& sweep) {
  std::vector<std::string> names;
  for (const sweep::SweepVariant& variant : sweep.variants) names.push_back(variant.folder);
  return names;
}

std::string refusal(const std::string& lines, const std::vector<std::string>& overrides = {}) {
  try {
    sweep::read_sweep("name: x\nsweep:\n" + lines, "s.yaml", overrides);
  } catch (const core::ConfigError& error) {
    return std::string(error.what());
  }
  return "accepted";
}

void expect_says(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts) {
    EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in: " << text;
  }
}

TEST(Sweep, AConfigurationWithoutOneHasNone) {
  EXPECT_FALSE(sweep::read_sweep("name: x\n", "s.yaml", {}));
  EXPECT_FALSE(sweep::read_sweep("name: x\nsweep: {keys: {a: [1, 2]}}\n", "s.yaml", {"sweep="}));
}

TEST(Sweep, TheLastKeyOfAGridChangesFastest) {
  const sweep::Sweep sweep =
      sweep_of("  keys:\n    modes.order: [2, 3]\n    room.rt60: [0.2 s, 0.5 s]\n");
  EXPECT_EQ(folders(sweep), (std::vector<std::string>{"order=2,rt60=0.2s", "order=2,rt60=0.5s",
                                                      "order=3,rt60=0.2s", "order=3,rt60=0.5s"}));
  EXPECT_EQ(sweep.variants[1].overrides,
            (std::vector<std::string>{"modes.order=2", "room.rt60=0.5 s"}));
}

TEST(Sweep, AZipTakesOneOfEachAndRefusesUnequalLists) {
  const std::string keys = "  mode: zip\n  keys:\n    a.b: [1, 2, 3]\n    c: [x, y";
  EXPECT_EQ(folders(sweep_of(keys + ", z]\n")),
            (std::vector<std::string>{"b=1,c=x", "b=2,c=y", "b=3,c=z"}));
  expect_says(refusal(keys + "]\n"), {"s.yaml:6:5", "sweep.keys.c: has 2 values and a.b has 3"});
}

TEST(Sweep, RangesByCountStepAndLogarithm) {
  const sweep::Sweep sweep = sweep_of(
      "  mode: zip\n  keys:\n    a: {from: 10 mm, to: 30 mm, count: 3}\n"
      "    b: {from: 1, to: 100, count: 3, spacing: log}\n    c: {from: 1, to: 2, step: 0.5}\n");
  ASSERT_EQ(sweep.variants.size(), 3u);
  EXPECT_EQ(sweep.variants[1].values, (std::vector<std::string>{"20 mm", "10", "1.5"}));
  EXPECT_EQ(sweep.variants[2].values, (std::vector<std::string>{"30 mm", "100", "2"}));
  // Ends stay as they are; 0.1 + 2 * 0.1 would not.
  const sweep::Sweep tenths = sweep_of("  keys: {a: {from: 0.1, to: 0.3, step: 0.1}}\n");
  EXPECT_EQ(tenths.variants.back().values.front(), "0.3");
}

TEST(Sweep, RangesThatCannotBeAreRefusedAtTheirPlace) {
  const auto range = [](const std::string& text) {
    return refusal("  keys:\n    a: {" + text + "}\n");
  };
  expect_says(range("from: 1 s, to: 2 m, count: 2"), {"s.yaml:4", "same unit"});
  expect_says(range("from: 2, to: 1, count: 2"), {"above"});
  expect_says(range("from: 0, to: 1, count: 2, spacing: log"), {"positive"});
  expect_says(range("from: 0, to: 1, cuont: 2"), {"sweep.keys.a.cuont", "did you mean \"count\""});
  expect_says(range("from: 0, to: 1, count: 2, step: 1"), {"beside count"});
  expect_says(range("from: 0, to: 1"), {"mode: random"});
  expect_says(range("from: 0, to: 1, step: 1e-9"), {"more than 10000"});
  expect_says(refusal("  keys:\n    modes: {order: [2, 3]}\n"), {"keys are dotted"});
}

TEST(Sweep, MistakesNameLineAndNearestKey) {
  expect_says(refusal("  mdoe: zip\n  keys: {a: [1]}\n"), {"s.yaml:3:3", "did you mean \"mode\""});
  expect_says(refusal("  mode: girs\n  keys: {a: [1]}\n"), {"grid"});
  expect_says(refusal("  count: 4\n  keys: {a: [1]}\n"), {"s.yaml:3:3", "count"});
  expect_says(refusal("  mode: grid\n"), {"names no key"});
  expect_says(refusal("  keys: {a: [1, 2, 1]}\n"), {"comes twice"});
  expect_says(refusal("  keys: {a: []}\n"), {"no values"});
  expect_says(refusal("  keys: {a.b: [1], a: [1]}\n"), {"overwrites a.b"});
  expect_says(refusal("  keys: {a.b: [1]}\n", {"a.b=2"}), {"--set a.b=2"});
  expect_says(refusal("  keys: {a: [[1]]}\n", {"a[0]=2"}), {"--set a[0]=2"});
  EXPECT_EQ(refusal("  keys: {a.bc: [1]}\n", {"a.b=2"}), "accepted");
  EXPECT_EQ(refusal("  keys: {a.b: [1]}\n", {"a={c: 1}"}), "accepted");
}

TEST(Sweep, TooManyVariantsAreRefused) {
  const std::string hundred = "{from: 1, to: 100, step: 1}";
  EXPECT_EQ(sweep_of("  keys: {a: " + hundred + ", b: " + hundred + "}\n").variants.size(), 10000u);
  expect_says(refusal("  keys: {a: " + hundred + ", b: " + hundred + ", c: [1, 2]}\n"),
              {"100 x 100 x 2", "more than 10000"});
}

TEST(Sweep, DrawsDependOnSeedKeyAndNumberAlone) {
  const std::string range = "{from: 0.1 s, to: 10 s, spacing: log}";
  const auto drawn = [&](int count, int seed, const std::string& keys) {
    return sweep_of("  mode: random\n  count: " + std::to_string(count) +
                    "\n  seed: " + std::to_string(seed) + "\n  keys: {" + keys + "}\n");
  };
  const sweep::Sweep few = drawn(5, 1, "a: " + range), many = drawn(20, 1, "a: " + range);
  const sweep::Sweep other = drawn(5, 1, "z: [1, 2, 3], a: " + range),
                     reseeded = drawn(5, 2, "a: " + range);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(few.variants[i].values[0], many.variants[i].values[0]);
    EXPECT_EQ(few.variants[i].values[0], other.variants[i].values[1]);
    EXPECT_NE(few.variants[i].values[0], reseeded.variants[i].values[0]);
  }
  int below = 0;
  for (const sweep::SweepVariant& variant : drawn(400, 3, "a: " + range).variants) {
    const double value = core::parse_quantity(variant.values[0], core::Dimension::time);
    EXPECT_GE(value, 0.1);
    EXPECT_LE(value, 10);
    below += value < 1 ? 1 : 0;  // the middle of the logarithm
  }
  EXPECT_NEAR(below, 200, 5 * std::sqrt(400 * 0.25));
}

TEST(Sweep, DrawsFromListsNeverRepeatAVariant) {
  const sweep::Sweep all =
      sweep_of("  mode: random\n  count: 6\n  keys: {a: [1, 2, 3], b: [x, y]}\n");
  const auto names = folders(all);
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), 6u);
  expect_says(refusal("  mode: random\n  count: 7\n  keys: {a: [1, 2, 3], b: [x, y]}\n"),
              {"count", "6 different"});
}

TEST(Sweep, ValuesAreTextsThatSetReadsBack) {
  const sweep::Sweep sweep = sweep_of(
      "  keys:\n    a:\n      - [steel, 'x, y']\n      - {kind: table, at: [0, \"1 m\"]}\n"
      "      - 'no: mapping'\n      - off\n");
  const std::vector<std::string> expected = {"[steel, \"x, y\"]", "{kind: table, at: [0, 1 m]}",
                                             "\"no: mapping\"", "off"};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(sweep.variants[i].values[0], expected[i]);
    core::ConfigTree root = core::parse_config_tree("{}", "s.yaml");
    core::apply_override(root, sweep.variants[i].overrides[0]);
    EXPECT_EQ(sweep::flow_text(root.find("a")->value), expected[i]);
  }
}

TEST(Sweep, NamedValuesNameFoldersAndRows) {
  const sweep::Sweep sweep =
      sweep_of("  keys:\n    room: {named: {dry: {rt60: 0.2}, wet: {rt60: 2, order: 5}}}\n");
  EXPECT_EQ(folders(sweep), (std::vector<std::string>{"room=dry", "room=wet"}));
  EXPECT_EQ(sweep.variants[1].values.front(), "wet");
  EXPECT_EQ(sweep.variants[1].overrides.front(), "room={rt60: 2, order: 5}");
  expect_says(refusal("  keys: {a: {named: {x: 1}, to: 3}}\n"), {"sweep.keys.a.to"});
}

TEST(Sweep, FoldersAreSafeAndDifferent) {
  const sweep::Sweep sweep = sweep_of("  keys: {a.x: ['../b', '..b', '//b'], b.x: [1]}\n");
  const auto names = folders(sweep);
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), 3u);
  for (const std::string& name : names) {
    EXPECT_EQ(name.find('/'), std::string::npos) << name;
    EXPECT_EQ(name.substr(0, 4), "a.x=") << "both keys end in x";
  }
}

TEST(Sweep, AVariantIsTheBuildThatItsOverridesGive) {
  const std::string text =
      "objects:\n  - shape: bar\n    materials: [steel]\n"
      "sweep: {keys: {modes.order: [1, 2], audio.seconds: [0.5 s, 1 s]}}\n";
  const auto sweep = sweep::read_sweep(text, "s.yaml", {});
  const auto plain = text.substr(0, text.find("sweep:"));
  for (const sweep::SweepVariant& variant : sweep->variants) {
    EXPECT_EQ(configuration::read_build_config(text, "s.yaml", variant.overrides).resolved,
              configuration::read_build_config(plain, "s.yaml", variant.overrides).resolved);
  }
}

RC_GTEST_PROP(SweepProperty, GrowingAGridRenamesNothing, ()) {
  const auto count = *rc::gen::inRange(1, 6);
  const auto more = *rc::gen::inRange(0, 4);
  const auto other = *rc::gen::inRange(1, 6);
  const auto list = [](int n) {
    std::string text;
    for (int i = 0; i < n; ++i) text += (i == 0 ? "" : ", ") + std::to_string(i * 7);
    return "[" + text + "]";
  };
  const auto names = [&](int a, int b) {
    const auto all = folders(sweep_of("  keys: {a: " + list(a) + ", b: " + list(b) + "}\n"));
    return std::set<std::string>(all.begin(), all.end());
  };
  const auto small = names(count, other), large = names(count + more, other + more);
  RC_ASSERT(small.size() == static_cast<std::size_t>(count * other));
  RC_ASSERT(std::includes(large.begin(), large.end(), small.begin(), small.end()));
}

}  // namespace
}  // namespace carillon::dataset
