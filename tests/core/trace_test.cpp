#include "core/trace.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace carillon::core {
namespace {

TEST(Trace, MergeAddsCallsAndSecondsByName) {
  Trace all, part;
  all.stages["mesh"] = {2, 1.5};
  part.stages["mesh"] = {1, 0.25};
  part.stages["solve"] = {4, 8.0};
  part.effects["room"] = {3, 0.5};
  all.merge(part);
  EXPECT_EQ(all.stages["mesh"], (Trace::Entry{3, 1.75}));
  EXPECT_EQ(all.stages["solve"], (Trace::Entry{4, 8.0}));
  EXPECT_EQ(all.effects["room"], (Trace::Entry{3, 0.5}));
  EXPECT_EQ(all.effects.size(), 1u);
}

TEST(ScopedTimer, AddsOneCallAndItsTimeEvenWhenAnExceptionPasses) {
  Trace::Entry entry{1, 10.0};
  EXPECT_THROW(
      {
        const ScopedTimer timer(entry);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        throw 1;
      },
      int);
  EXPECT_EQ(entry.calls, 2);
  EXPECT_GE(entry.seconds, 10.02);
}

TEST(MonotonicSeconds, NeverGoesBack) {
  double last = monotonic_seconds();
  for (int i = 0; i < 1000; ++i) {
    const double now = monotonic_seconds();
    ASSERT_GE(now, last);
    last = now;
  }
}

}  // namespace
}  // namespace carillon::core
