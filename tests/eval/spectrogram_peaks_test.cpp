// The papers' extractor: peaks are looked for until they account for a fraction of the power.
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "eval/features/extract_features.hpp"
#include "tests/eval/strike_clip.hpp"

namespace carillon::eval {
namespace {

TEST(SpectrogramPeaks, EndWhereTheyExplainTheFractionAskedFor) {
  // Energies a^2 / (4 d): 100, 10 and 1 parts.
  const std::vector<Partial> partials = {
      {700, 8, 1, 0}, {2000, 8, std::sqrt(0.1), 1}, {5000, 8, 0.1, 2}};
  const ClipShape shape{44100, 1, 0};
  const std::vector<double> samples = strike_clip(partials, shape);
  const auto found = [&](double explained) {
    features::FeatureOptions options;
    options.method = features::FeatureMethod::peaks;
    options.explained = explained;
    return features::extract_features(samples, shape.sample_rate, options).features.size();
  };
  EXPECT_EQ(found(0.5), 1u);
  EXPECT_EQ(found(0.95), 2u);
  EXPECT_GE(found(0.9999), 3u);
}

TEST(SpectrogramPeaks, RefuseAFractionThatIsNone) {
  features::FeatureOptions options;
  options.explained = 1.5;
  EXPECT_THROW(features::extract_features(std::vector<double>(1000), 44100, options),
               core::InputError);
}

}  // namespace
}  // namespace carillon::eval
