#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/config.hpp"
#include "core/error.hpp"

namespace carillon::core {
namespace {

const std::string document =
    "seed: 1\n"
    "audio:\n"
    "  seconds: 1 s\n"
    "objects:\n"
    "  - family: cup\n"
    "    count: 2\n"
    "  - family: bar\n";

ConfigNode with(const std::vector<std::string>& overrides) {
  return ConfigNode::parse(document, "c.yaml", overrides);
}

template <class Read>
std::string refusal(const std::vector<std::string>& overrides, const Read& read) {
  try {
    ConfigNode root = with(overrides);
    read(root);
    return "accepted";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

std::string refusal(const std::vector<std::string>& overrides) {
  return refusal(overrides, [](ConfigNode&) {});
}

TEST(ConfigOverrides, ReplaceValues) {
  ConfigNode root = with({"seed=7", "audio.seconds=250 ms", "objects[1].family=plate"});
  EXPECT_EQ(root.integer("seed", 0, 9), 7);
  EXPECT_EQ(root.child("audio").quantity("seconds", Dimension::time), 0.25);
  EXPECT_EQ(root.children("objects")[0].text("family"), "cup");
  EXPECT_EQ(root.children("objects")[1].text("family"), "plate");
}

TEST(ConfigOverrides, MakeMissingKeysAndAppend) {
  ConfigNode root =
      with({"room.walls.count=6", "objects[2].family=vase", "list[0]=a", "list[1]=b"});
  EXPECT_EQ(root.child("room").child("walls").integer("count", 0, 9), 6);
  ASSERT_EQ(root.children("objects").size(), 3u);
  EXPECT_EQ(root.children("objects")[2].text("family"), "vase");
  EXPECT_EQ(root.texts("list"), (std::vector<std::string>{"a", "b"}));
}

TEST(ConfigOverrides, TakeListsMappingsAndTextsWithEqualsSigns) {
  ConfigNode root = with({"range=[1 cm, 2 cm]", "audio={rate: 8 kHz}", "note=a=b", "empty=''"});
  EXPECT_EQ(root.range("range", Dimension::length), (Range{0.01, 0.02}));
  EXPECT_EQ(root.child("audio").keys(), std::vector<std::string>{"rate"});
  EXPECT_EQ(root.text("note"), "a=b");
  EXPECT_EQ(root.text("empty"), "");
}

TEST(ConfigOverrides, TheLastOneHolds) {
  EXPECT_EQ(with({"seed=2", "seed=3"}).integer("seed", 0, 9), 3);
}

TEST(ConfigOverrides, MessagesNameThem) {
  EXPECT_EQ(
      refusal({"audio.seconds=2 kg"},
              [](ConfigNode& root) { root.child("audio").quantity("seconds", Dimension::time); }),
      "--set audio.seconds=2 kg: audio.seconds: \"2 kg\" is a mass; a time is wanted\n"
      "  hint: units of a time: s, ms, us, min, h; a bare number is in s");
  EXPECT_EQ(refusal({"sede=2"},
                    [](ConfigNode& root) {
                      root.integer("seed", 0, 9);
                      root.child("audio").quantity("seconds", Dimension::time);
                      for (ConfigNode& one : root.children("objects")) {
                        one.text("family");
                        one.integer("count", 0, 9, 1);
                      }
                      root.finish();
                    }),
            "--set sede=2: sede: unknown key; did you mean \"seed\"?");
  EXPECT_EQ(refusal({"objects[2].count=1"},
                    [](ConfigNode& root) { root.children("objects")[2].text("family"); }),
            "--set objects[2].count=1: objects[2].family: missing; a text is wanted");
  EXPECT_EQ(refusal({"seed="}, [](ConfigNode& root) { root.integer("seed", 0, 9); }),
            "--set seed=: seed: has no value; a whole number from 0 to 9 is wanted");
}

TEST(ConfigOverrides, WrongFormsAreRefused) {
  const auto starts = [](const std::string& assignment, const std::string& message) {
    const std::string answer = refusal({assignment});
    EXPECT_EQ(answer.substr(0, answer.find('\n')), "--set " + assignment + ": " + message);
  };
  starts("seed", "there is no \"=\"");
  starts("=5", "a key is missing in \"\"");
  starts("audio..x=5", "a key is missing in \"audio..x\"");
  starts("audio.=5", "a key is missing in \"audio.\"");
  starts("objects[x]=5", "\"objects[x]\" is not of the form name[0]");
  starts("objects[0=5", "\"objects[0\" is not of the form name[0]");
  starts("objects[0]y=5", "\"objects[0]y\" is not of the form name[0]");
  starts("objects[]=5", "\"objects[]\" is not of the form name[0]");
  starts("objects[-1]=5", "\"objects[-1]\" is not of the form name[0]");
  starts("objects[9].count=5", "objects has 2 elements; the next to append is objects[2]");
  starts("seed.x=5", "seed is not a mapping of keys");
  starts("objects.count=5", "objects is not a mapping of keys");
  starts("audio[0]=5", "audio is not a list");
  EXPECT_EQ(refusal({"a=[1"}).substr(0, 28), "--set a=[1: malformed YAML: ");
  EXPECT_NE(refusal({"objects.count=5"}).find("its elements are objects[0] to objects[1]"),
            std::string::npos);
}

}  // namespace
}  // namespace carillon::core
