#include "core/folder_name.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace carillon::core {
namespace {

std::string name_in(const std::string& text, const std::string& file = "folder/set.yaml") {
  ConfigNode root = ConfigNode::parse(text, file);
  return folder_name(root, file);
}

TEST(FolderName, IsTheKeysOrTheFiles) {
  EXPECT_EQ(name_in("name: kitchen-2_b.c"), "kitchen-2_b.c");
  EXPECT_EQ(name_in("name: K\u00fcche"), "K\u00fcche");
  EXPECT_EQ(name_in("seed: 1"), "set");
  EXPECT_EQ(name_in("seed: 1", "my sounds (2).yaml"), "my-sounds--2-");
  EXPECT_EQ(name_in("seed: 1", ".yaml"), "yaml");
  EXPECT_EQ(name_in("seed: 1", "..."), "dataset");
}

TEST(FolderName, LeadsNowhereElse) {
  for (const char* name : {"../other", "a/b", "/tmp", ".", "..", ".hidden", "-rf", "\"\"",
                           "\"a b\"", "\"a\\nb\"", "a:b", "~"}) {
    EXPECT_THROW(name_in(std::string("name: ") + name), ConfigError) << name;
  }
  EXPECT_THROW(name_in("name: " + std::string(101, 'a')), ConfigError);
  try {
    name_in("seed: 1\nname: ../other");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.message(), "folder/set.yaml:2:7: name: \"../other\" is no name of a folder");
  }
}

}  // namespace
}  // namespace carillon::core
