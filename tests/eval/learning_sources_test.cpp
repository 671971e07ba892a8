// Several sources of sounds: what one is learnt from must not be tested in another.
#include "eval/studies/learning/learning_sources.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "tests/eval/learning/made_source.hpp"

namespace carillon::eval {
namespace {

void require(const MadeSource& one, const MadeSource& other, const std::string& split) {
  studies::require_one_part({&one, &other}, split);
}

TEST(SeveralSources, HaveEveryStrikeInOnePart) {
  MadeSource one(30, 3), other(30, 3);
  one.columns["split_strike"] = other.columns["split_strike"] =
      std::vector<std::string>(30, "train");
  require(one, other, "split_strike");
  other.columns["split_strike"][4] = "test";
  try {
    require(one, other, "split_strike");
    FAIL() << "a strike is learnt from and tested";
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("sample-4: the same strike is in test here and in train"),
              std::string::npos)
        << error.message();
    EXPECT_FALSE(error.hint().empty());
  }
}

TEST(SeveralSources, HaveEveryObjectInOnePartWhereObjectsAreHeldOut) {
  MadeSource one(30, 3), other(30, 3);
  // Objects 0, 1 and 2 in turn; in the other one object 2 is tested.
  one.columns["split_shape"] = other.columns["split_shape"] = std::vector<std::string>(30, "train");
  for (std::size_t i = 2; i < 30; i += 3) other.columns["split_shape"][i] = "test";
  EXPECT_THROW(require(one, other, "split_shape"), core::InputError);
  other.columns["object"] = one.labels("object");
  for (std::size_t i = 2; i < 30; i += 3) other.columns["object"][i] = "another";
  require(one, other, "split_shape");
}

}  // namespace
}  // namespace carillon::eval
