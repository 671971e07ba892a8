#include "core/config.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

using Texts = std::vector<std::string>;

TEST(Config, ReadsQuantitiesInSi) {
  ConfigNode root = ConfigNode::parse(
      "length: 12 cm\nquoted: \"20 kHz\"\nbare: 0.5\nexponent: 2.1e11\nfraction: 5 %\n", "c.yaml");
  EXPECT_EQ(root.quantity("length", Dimension::length), 0.12);
  EXPECT_EQ(root.quantity("quoted", Dimension::frequency), 20000);
  EXPECT_EQ(root.quantity("bare", Dimension::time), 0.5);
  EXPECT_EQ(root.quantity("exponent", Dimension::pressure), 2.1e11);
  EXPECT_EQ(root.quantity("fraction", Dimension::none), 0.05);
  EXPECT_EQ(root.quantity("absent", Dimension::mass, 3.0), 3.0);
  root.finish();
}

TEST(Config, ReadsRangesAndLists) {
  ConfigNode root = ConfigNode::parse(
      "one: 3 mm\ntwo: [3 mm, 1 cm]\npoint: [1 m, 2 cm, 3 mm]\nempty: []\n", "c.yaml");
  EXPECT_EQ(root.range("one", Dimension::length), (Range{0.003, 0.003}));
  EXPECT_EQ(root.range("two", Dimension::length), (Range{0.003, 0.01}));
  EXPECT_EQ(root.range("absent", Dimension::length, Range{1, 2}), (Range{1, 2}));
  EXPECT_EQ(root.quantities("point", Dimension::length, 3), (std::vector<double>{1, 0.02, 0.003}));
  EXPECT_EQ(root.quantities("empty", Dimension::length), std::vector<double>{});
  EXPECT_EQ(root.quantities("gone", Dimension::none, 2, std::vector<double>{4, 5}),
            (std::vector<double>{4, 5}));
}

TEST(Config, ReadsIntegersOfEverySpelling) {
  ConfigNode root = ConfigNode::parse(
      "a: 12\nb: -3\nc: 1e4\nd: +7\ne: 9223372036854775807\nf: -9223372036854775808\ng: 5.0\n"
      "h: 010\n",
      "c.yaml");
  const std::int64_t low = INT64_MIN, high = INT64_MAX;
  EXPECT_EQ(root.integer("a", low, high), 12);
  EXPECT_EQ(root.integer("b", low, high), -3);
  EXPECT_EQ(root.integer("c", low, high), 10000);
  EXPECT_EQ(root.integer("d", low, high), 7);
  EXPECT_EQ(root.integer("e", low, high), high);
  EXPECT_EQ(root.integer("f", low, high), low);
  EXPECT_EQ(root.integer("g", low, high), 5);
  EXPECT_EQ(root.integer("h", low, high), 10);
  EXPECT_EQ(root.integer("absent", 0, 9, 4), 4);
}

TEST(Config, EveryIntegerReadsBack) {
  EXPECT_TRUE(rc::check([](std::int64_t value) {
    ConfigNode root = ConfigNode::parse("n: " + std::to_string(value), "c.yaml");
    RC_ASSERT(root.integer("n", INT64_MIN, INT64_MAX) == value);
  }));
}

TEST(Config, ReadsFlagsTextsAndChoices) {
  ConfigNode root = ConfigNode::parse(
      "on: true\noff: No\nname: 'it''s 3 #1'\nnumber: 007\nempty: \"\"\nmany: [a, 'b c', 3]\n"
      "single: alone\nmaterial: glass\n",
      "c.yaml");
  EXPECT_TRUE(root.flag("on", false));
  EXPECT_FALSE(root.flag("off", true));
  EXPECT_TRUE(root.flag("absent", true));
  EXPECT_EQ(root.text("name"), "it's 3 #1");
  EXPECT_EQ(root.text("number"), "007");
  EXPECT_EQ(root.text("empty"), "");
  EXPECT_EQ(root.text("absent2", "fallback"), "fallback");
  EXPECT_EQ(root.texts("many"), (Texts{"a", "b c", "3"}));
  EXPECT_EQ(root.texts("single"), Texts{"alone"});
  EXPECT_EQ(root.texts("absent3", Texts{"x"}), Texts{"x"});
  EXPECT_EQ(root.choice("material", {"steel", "glass"}), "glass");
  EXPECT_EQ(root.choice("absent4", {"steel", "glass"}, "steel"), "steel");
}

TEST(Config, ChildrenHavePathsAndOrder) {
  ConfigNode root = ConfigNode::parse(
      "audio:\n  room:\n    size: 3\nobjects:\n- family: cup\n- family: bar\nnothing:\n", "c.yaml");
  ConfigNode room = root.child("audio").child("room");
  EXPECT_EQ(room.path(), "audio.room");
  EXPECT_EQ(room.quantity("size", Dimension::length), 3);
  auto objects = root.children("objects");
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[1].path(), "objects[1]");
  EXPECT_EQ(objects[1].text("family"), "bar");
  EXPECT_EQ(objects[0].text("family"), "cup");
  EXPECT_TRUE(root.children("absent").empty());
  EXPECT_EQ(root.child("missing").quantity("x", Dimension::none, 1.0), 1.0);
  EXPECT_EQ(root.child("nothing").quantity("x", Dimension::none, 2.0), 2.0);
  root.finish();
}

TEST(Config, KeysComeInTheirOrder) {
  ConfigNode root = ConfigNode::parse("zinc: 1\nbrass: 2\n\"odd key\": 3\n", "c.yaml");
  EXPECT_EQ(root.keys(), (Texts{"zinc", "brass", "odd key"}));
  EXPECT_TRUE(root.has("brass"));
  EXPECT_FALSE(root.has("steel"));
}

TEST(Config, AskingTwiceGivesTheSameAnswerAndTheSameChild) {
  ConfigNode root = ConfigNode::parse("a: 1\nb: {c: 2}\nd: [{e: 3}]\n", "c.yaml");
  EXPECT_EQ(root.quantity("a", Dimension::none), root.quantity("a", Dimension::none));
  root.child("b").quantity("c", Dimension::none);
  EXPECT_EQ(root.child("b").quantity("c", Dimension::none), 2);
  root.children("d")[0].quantity("e", Dimension::none);
  root.children("d");
  root.finish();  // the second child() and children() forget nothing
}

TEST(Config, FollowsAliasesAndMergeKeys) {
  ConfigNode root = ConfigNode::parse(
      "cup: &cup {family: cup, wall: 3 mm}\n"
      "objects:\n"
      "- <<: *cup\n"
      "  wall: 4 mm\n"
      "- *cup\n"
      "- <<: [{family: bar, a: 1}, *cup]\n",
      "c.yaml");
  auto objects = root.children("objects");
  EXPECT_EQ(objects[0].text("family"), "cup");
  EXPECT_EQ(objects[0].quantity("wall", Dimension::length), 0.004);
  EXPECT_EQ(objects[1].quantity("wall", Dimension::length), 0.003);
  EXPECT_EQ(objects[2].keys(), (Texts{"family", "a", "wall"}));
  EXPECT_EQ(objects[2].text("family"), "bar");
}

TEST(Config, AnEmptyTextIsAnEmptyMapping) {
  for (const char* text : {"", "\n", "# only a comment\n", "{}", "---\n", "\xef\xbb\xbf"}) {
    ConfigNode root = ConfigNode::parse(text, "c.yaml");
    EXPECT_TRUE(root.keys().empty());
    root.finish();
  }
}

TEST(Config, CopiesShareWhatWasAsked) {
  ConfigNode root = ConfigNode::parse("a: 1\n", "c.yaml");
  ConfigNode copy = root;
  copy.quantity("a", Dimension::none);
  root.finish();
}

TEST(Config, ChildrenOutliveTheirRoot) {
  ConfigNode child = ConfigNode::parse("a: {b: 5}\n", "c.yaml").child("a");
  EXPECT_EQ(child.quantity("b", Dimension::none), 5);
}

TEST(Config, KeysOfAnotherReaderMayStand) {
  ConfigNode root = ConfigNode::parse("a: 1\nobjects: [{x: 1}]\n", "c.yaml");
  root.quantity("a", Dimension::none);
  EXPECT_THROW(root.finish(), ConfigError);
  root.leave_alone({"objects", "absent"});
  root.finish();
}

TEST(Config, TellsWhereAKeyWasWritten) {
  const ConfigNode root =
      ConfigNode::parse("a: 1\n\nroom: {order: 2}\n", "/folder/c.yaml", {"b=2"});
  EXPECT_EQ(root.where("room"), "c.yaml:3");
  EXPECT_EQ(root.where("b"), "--set b=2");
  EXPECT_EQ(root.where("none"), "");
}

TEST(ReadTextFile, GivesTheTextOrTheReason) {
  const TemporaryFolder folder;
  write_text_durably(folder / "c.yaml", "seed: 1\n");
  EXPECT_EQ(read_text_file(folder / "c.yaml"), "seed: 1\n");
  EXPECT_THROW(read_text_file(folder / "absent.yaml"), FileError);
}

}  // namespace
}  // namespace carillon::core
