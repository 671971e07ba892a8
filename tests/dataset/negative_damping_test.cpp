// Damping that turns negative is told when a configuration is read, before any object is solved.
#include <gtest/gtest.h>

#include <string>

#include "dataset/configuration/configuration.hpp"

namespace carillon::dataset {
namespace {

/// Negative between 800 and 3,000 Hz.
const std::string dip =
    "\"youngs_modulus=70 GPa,poisson_ratio=0.2,density=2500,damping=1e-3*(f-800)*(f-3000)\"";

configuration::BuildConfig with(const std::string& materials, const std::string& more = "") {
  return configuration::read_build_config(
      "objects:\n  - shape: bar\n    materials: [" + materials + "]\n" + more, "test.yaml", {});
}

std::string damping_reason(const configuration::BuildConfig& config) {
  for (const scene::EffectDecision& decision : config.scene.effects) {
    if (decision.effect->name == std::string_view("damping")) return decision.reason;
  }
  return "no such effect";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(NegativeDamping, IsToldWithMaterialRangeAndOutcome) {
  const configuration::BuildConfig config = with("steel, " + dip);
  const std::string reason = damping_reason(config);
  EXPECT_TRUE(contains(reason, "every material has damping")) << reason;
  EXPECT_TRUE(contains(reason, "(f-3000) from 800 to 3000 Hz")) << reason;
  EXPECT_TRUE(contains(reason, "a mode there will fail its object")) << reason;
  EXPECT_FALSE(contains(reason, "steel")) << reason;
  ASSERT_EQ(config.warnings.size(), 1u);
  EXPECT_TRUE(contains(config.warnings[0], "800 to 3000 Hz")) << config.warnings[0];
  EXPECT_TRUE(contains(damping_reason(with(dip, "negative_damping: clamp\n")),
                       "undamped (negative_damping: clamp)"));
  EXPECT_TRUE(contains(damping_reason(with(dip, "negative_damping: drop\n")), "left out"));
}

TEST(NegativeDamping, IsLookedForInTheBand) {
  const configuration::BuildConfig cut =
      with(dip, "modes: {min_frequency: 0, max_frequency: 1 kHz}\n");
  EXPECT_TRUE(contains(damping_reason(cut), "800 to 1000 Hz")) << damping_reason(cut);
  const configuration::BuildConfig above = with(dip, "modes: {min_frequency: 4 kHz}\n");
  EXPECT_FALSE(contains(damping_reason(above), "negative")) << damping_reason(above);
  EXPECT_TRUE(above.warnings.empty());
}

TEST(NegativeDamping, IsNoMatterWhereThereIsNone) {
  EXPECT_TRUE(with("steel, sterling_wood_hybrid, gpd_wood_caughey").warnings.empty());
  EXPECT_TRUE(with(dip, "effects: {damping: off}\n").warnings.empty());
}

}  // namespace
}  // namespace carillon::dataset
