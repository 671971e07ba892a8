// Tables of features in the units and names that others write.
#include "eval/features/feature_table.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::eval::features {
namespace {

std::vector<Feature> read(const std::string& text) {
  const core::TemporaryFolder folder;
  core::write_text_durably(folder.path() / "mug.csv", text);
  return read_feature_table(folder.path() / "mug.csv");
}

std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "none";
}

void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

// One mode by every quantity: 1 kHz damped, zeta = 0.002.
TEST(FeatureTable, EveryQuantityGivesTheSameDecay) {
  const double omega = 2 * std::numbers::pi * 1000, zeta = 0.002;
  const double d = omega * zeta / std::sqrt(1 - zeta * zeta);
  const std::pair<std::string, double> columns[] = {{"decay_rate_per_s", d},
                                                    {"Decay rate (1/s)", d},
                                                    {"d [dB/s]", d * 20 / std::log(10.0)},
                                                    {"damping_ratio", zeta},
                                                    {"zeta [%]", 100 * zeta},
                                                    {"Q", 1 / (2 * zeta)},
                                                    {"quality factor", 1 / (2 * zeta)},
                                                    {"loss_factor", 2 * zeta},
                                                    {"eta (%)", 200 * zeta},
                                                    {"t60_s", std::log(1000.0) / d},
                                                    {"T60 [ms]", 1000 * std::log(1000.0) / d}};
  for (const auto& [name, value] : columns) {
    for (const char* frequency : {"frequency_hz,", "Frequency (Hz),"}) {
      const auto features = read(frequency + name + "\n1000," + fmt::format("{:.17g}\n", value));
      ASSERT_EQ(features.size(), 1u) << name;
      EXPECT_NEAR(features[0].decay_rate / d, 1, 1e-12) << name;
      EXPECT_TRUE(std::isnan(features[0].decay_rate_error));
    }
  }
  EXPECT_NEAR(read("frequency (kHz),d\n1.25,6\n")[0].frequency, 1250, 1e-9);
  EXPECT_NEAR(read("frequency (rad/s),d\n6283.185307179586,6\n")[0].frequency, 1000, 1e-9);
}

// Errors follow the slope: twice the quantity's error by central differences of the decay rate.
TEST(FeatureTable, ErrorsAreConvertedByTheSlope) {
  const std::pair<std::string, double> columns[] = {
      {"damping_ratio", 0.05}, {"q", 12}, {"loss_factor", 0.08}, {"t60_ms", 700}, {"d_db/s", 90}};
  for (const auto& [name, value] : columns) {
    const std::string error = name.substr(0, name.find('_')) == "d" ? "d_error_db/s"
                              : name == "t60_ms"                    ? "t60_error_ms"
                                                                    : name + "_error";
    const double step = 1e-4 * value;
    const auto at = [&, quantity = name](double v) {
      return read("frequency_hz," + quantity + "\n800," + fmt::format("{:.17g}\n", v))[0]
          .decay_rate;
    };
    const auto feature = read("frequency_hz," + name + "," + error + "\n800," +
                              fmt::format("{:.17g},{:.17g}\n", value, 0.01 * value))[0];
    const double slope = std::abs(at(value + step) - at(value - step)) / (2 * step);
    EXPECT_NEAR(feature.decay_rate_error / (slope * 0.01 * value), 1, 1e-6) << name;
  }
}

TEST(FeatureTable, ColumnsThatSayTheSameMustAgree) {
  const auto both =
      read("frequency_hz,decay_rate_per_s,T60 [ms]\n440,6,1150\n500,7,\n600,,986.8\n");
  ASSERT_EQ(both.size(), 3u);
  EXPECT_EQ(both[0].decay_rate, 6);
  EXPECT_NEAR(both[2].decay_rate, 7, 1e-3);
  const std::string text = refusal("frequency_hz,d,T60 [ms]\n440,6,1150\n500,7,1150\n");
  expect_contains(text, "mug.csv:3: d means a decay rate of 7 1/s, T60 [ms] one of 6.007 1/s");
}

TEST(FeatureTable, WhatCannotBeReadIsNamedByItsPlace) {
  expect_contains(refusal("frequency_hz,T60 [min]\n440,1\n"), "mug.csv:1: column \"T60 [min]\"");
  expect_contains(refusal("frequency_hz,note\n440,1\n"),
                  "mug.csv:1: no column \"decay_rate_per_s\"");
  expect_contains(refusal("q\n440\n"), "mug.csv:1: no column \"frequency_hz\"");
  expect_contains(refusal("f,d,decay_rate [1/s]\n440,1,1\n"), "\"d\" and \"decay_rate [1/s]\"");
  expect_contains(refusal("f,zeta\n440,0.01\n440,1.5\n"), "mug.csv:3: zeta is 1.5");
  expect_contains(refusal("f,Q\n440,0.4\n"), "mug.csv:2: Q is 0.4");
  expect_contains(refusal("f,Q\n440,x\n"), "mug.csv:2: Q is \"x\", which is no number");
  expect_contains(refusal("f,d,q\n440,,\n"), "mug.csv:2: q is \"\"");
}

// Words that begin as a column's name does are other columns.
TEST(FeatureTable, OtherColumnsAreNotRead) {
  const auto features =
      read("date,frequency_hz,decay_rate_per_s,quality,feature,amplitudes,t60s\nx,440,6,a,b,c,d\n");
  ASSERT_EQ(features.size(), 1u);
  EXPECT_TRUE(std::isnan(features[0].amplitude));
}

}  // namespace
}  // namespace carillon::eval::features
