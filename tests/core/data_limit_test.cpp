// The limit on a process's data, and its rests.
#include <gtest/gtest.h>

#include <fstream>
#include <new>
#include <optional>

#include "core/data_limit.hpp"
#include "core/error.hpp"
#include "core/sanitizers.hpp"

namespace carillon::core {
namespace {

std::int64_t data() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t pages = 0;
  for (int field = 0; field < 6; ++field) statm >> pages;
  return pages * 4096;
}

/// More than is left over anywhere.
bool can_have_much() {
  try {
    ::operator delete(::operator new(256 << 20));
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

TEST(DataLimit, HoldsWhileItLivesAndRestsWhileAnyRests) {
  if (core::address_sanitizer) GTEST_SKIP() << "AddressSanitizer knows no limits of memory";
  std::optional<DataLimit> limit(data() + (8 << 20));
  EXPECT_FALSE(can_have_much());
  {
    const DataLimitRests one;
    EXPECT_TRUE(can_have_much());
    { const DataLimitRests two; }
    EXPECT_TRUE(can_have_much());
  }
  EXPECT_FALSE(can_have_much());
  EXPECT_THROW(DataLimit(1), Error);
  limit.reset();
  EXPECT_TRUE(can_have_much());
}

/// A rest that outlives the limit leaves none behind, and a limit that begins in one waits for it.
TEST(DataLimit, MayEndAndBeginInARest) {
  if (core::address_sanitizer) GTEST_SKIP() << "AddressSanitizer knows no limits of memory";
  std::optional<DataLimit> limit(data() + (8 << 20));
  std::optional<DataLimitRests> rest(std::in_place);
  limit.reset();
  EXPECT_TRUE(can_have_much());
  rest.reset();
  EXPECT_TRUE(can_have_much());
  rest.emplace();
  limit.emplace(data() + (8 << 20));
  EXPECT_TRUE(can_have_much());
  rest.reset();
  EXPECT_FALSE(can_have_much());
}

TEST(DataLimit, NoneIsNone) {
  const DataLimit none(0);
  EXPECT_TRUE(can_have_much());
}

}  // namespace
}  // namespace carillon::core
