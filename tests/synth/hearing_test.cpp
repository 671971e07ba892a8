#include "synth/modal/hearing.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace carillon::synth {
namespace {

TEST(Hearing, AgreesWithTheTables) {
  // Zwicker's critical-band rate at 100 Hz, 1 kHz, 10 kHz; Terhardt's threshold at 1 and 4 kHz.
  EXPECT_NEAR(modal::bark(100), 1.0, 0.05);
  EXPECT_NEAR(modal::bark(1000), 8.5, 0.05);
  EXPECT_NEAR(modal::bark(10000), 22.4, 0.1);
  EXPECT_NEAR(modal::hearing_threshold(1000), 3.37, 0.02);
  EXPECT_NEAR(modal::hearing_threshold(4000), -3.39, 0.02);
  EXPECT_TRUE(std::isinf(modal::hearing_threshold(0)));
}

}  // namespace
}  // namespace carillon::synth
