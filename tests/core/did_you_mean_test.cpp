#include "core/did_you_mean.hpp"

#include <gtest/gtest.h>

namespace carillon::core {
namespace {

TEST(DidYouMean, NamesTheNearest) {
  EXPECT_EQ(did_you_mean("stell", {"glass", "steel"}), "; did you mean \"steel\"?");
  EXPECT_EQ(did_you_mean("unobtainium", {"glass", "steel"}), "");
  EXPECT_EQ(did_you_mean("", {"glass", "bell_bronze"}), "");
}

// "bronze" is nearer to "bone" by its letters.
TEST(DidYouMean, NamesThoseThatHaveTheWord) {
  EXPECT_EQ(did_you_mean("bronze", {"bone", "bell_bronze"}), "; did you mean \"bell_bronze\"?");
  EXPECT_EQ(did_you_mean("cast", {"grey_cast_iron", "cast_iron", "castle", "iron_cast"}),
            "; did you mean \"grey_cast_iron\", \"cast_iron\" or \"iron_cast\"?");
}

}  // namespace
}  // namespace carillon::core
