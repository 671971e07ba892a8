#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "core/disjoint_sets.hpp"

namespace carillon::core {

TEST(DisjointSets, AreApartUntilTheyAreJoined) {
  DisjointSets sets(4);
  EXPECT_EQ(sets.size(), 4);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(sets.find(i), i);
  sets.join(3, 1);
  EXPECT_EQ(sets.find(3), 1);
  EXPECT_EQ(sets.find(2), 2);
}

/// Against marking all of one set as the other at each join.
RC_GTEST_PROP(DisjointSets, AreNamedByTheirLowestNumber, ()) {
  const std::size_t count = *rc::gen::inRange<std::size_t>(1, 30);
  const auto number = rc::gen::inRange<std::size_t>(0, count);
  DisjointSets sets(count);
  std::vector<std::size_t> name(count);
  for (std::size_t i = 0; i < count; ++i) name[i] = i;
  for (const auto& [a, b] : *rc::gen::container<std::vector<std::pair<std::size_t, std::size_t>>>(
           rc::gen::pair(number, number))) {
    sets.join(a, b);
    const std::size_t low = std::min(name[a], name[b]), high = std::max(name[a], name[b]);
    std::replace(name.begin(), name.end(), high, low);
  }
  for (std::size_t i = 0; i < count; ++i) RC_ASSERT(sets.find(i) == name[i]);
}

}  // namespace carillon::core
