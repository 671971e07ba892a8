// Keys of earlier versions are told by what they are called now.
#include <gtest/gtest.h>

#include <functional>

#include "core/config.hpp"
#include "core/detail/renamed_keys.hpp"
#include "core/error.hpp"

namespace carillon::core {
namespace {

std::string refusal(const std::string& text, const std::function<void(ConfigNode&)>& read) {
  try {
    ConfigNode root = ConfigNode::parse(text, "c.yaml");
    read(root);
    root.finish();
    return "accepted";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

TEST(RenamedKeys, AnUnknownKeyOfAnEarlierVersionIsToldByItsName) {
  const auto read = [](ConfigNode& root) {
    root.child("levels").quantities("tolerances", Dimension::none, 0, std::vector<double>{1e-12});
    root.text("tolerance", "");  // nearer, and another thing
  };
  EXPECT_EQ(refusal("tolerances: [1e-9]\n", read),
            "c.yaml:1:1: tolerances: is now \"levels.tolerances\"");
}

TEST(RenamedKeys, ADocumentWithoutTheNewKeyIsOfAnotherKind) {
  EXPECT_EQ(renamed_key("tolerances", {"modes", "objects"}), "");
  EXPECT_EQ(renamed_key("tolerances", {"levels"}), "levels.tolerances");
}

TEST(RenamedKeys, PathsAreComparedFromTheirEndsWithoutNumbers) {
  EXPECT_EQ(renamed_key("objects[3].tolerances", {"levels"}), "levels.tolerances");
  EXPECT_EQ(renamed_key("objects[3].tolerance", {"levels"}), "");
  EXPECT_EQ(renamed_key("sound.scene.room.order", {"dimensions", "image_order"}), "image_order");
  EXPECT_EQ(renamed_key("train.methods.isnn-a.width", {"units"}), "units");
}

TEST(RenamedKeys, AMissingKeyIsToldThatItsOldNameStandsThere) {
  EXPECT_EQ(
      refusal(
          "room:\n  size: [5, 4, 3]\n",
          [](ConfigNode& root) { root.child("room").ranges("dimensions", Dimension::length, 3); }),
      "c.yaml:2:3: room.dimensions: missing; a list of 3 elements, each a value in m or a list "
      "[low, high], is wanted\n  hint: \"size\" (c.yaml:2:3) is now \"dimensions\"");
}

}  // namespace
}  // namespace carillon::core
