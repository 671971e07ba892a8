// Sounds of no class that a network meets while it learns.
#include "eval/networks/detail/outliers.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/eval/learning/made_source.hpp"

namespace carillon::eval {
namespace {

constexpr std::int64_t bands = 64, frames = 25;

networks::Outliers made_outliers() {
  learning::Method method = made_method({learning::Branch::isnn});
  method.spectrogram = {};
  return networks::Outliers(method, learning::paper_format(22050, 22050));
}

TEST(Outliers, AreNoisesAndMixesOfTwoClasses) {
  torch::manual_seed(1);
  const networks::Outliers outliers = made_outliers();
  // Class 0 is 2 everywhere, class 1 is 3: prepared sounds are below 1.
  const torch::Tensor labels = torch::tensor({0, 1}, torch::kInt64).repeat({16});
  const torch::Tensor batch = (labels + 2).view({32, 1, 1, 1}).expand({32, 1, bands, frames});
  std::int64_t noises = 0, mixes = 0;
  for (int step = 0; step < 20; ++step) {
    const torch::Tensor drawn = outliers.draw({batch.to(torch::kFloat32)}, labels).front();
    for (std::int64_t i = 0; i < drawn.size(0); ++i) {
      const torch::Tensor one = drawn[i][0];
      if (one.max().item<float>() <= 1) {
        ++noises;
        EXPECT_GT(one.mean().item<float>(), 0.02);
        continue;
      }
      ++mixes;
      // Frames are alike: low bands of one class, from the border on those of the other.
      EXPECT_TRUE(one.eq(one.select(1, 0).unsqueeze(1)).all().item<bool>());
      const float low = one[0][0].item<float>(), high = one[bands - 1][0].item<float>();
      EXPECT_EQ(low + high, 5);
      const auto border = one.select(1, 0).eq(low).sum().item<std::int64_t>();
      EXPECT_TRUE(one.select(1, 0).slice(0, 0, border).eq(low).all().item<bool>());
      EXPECT_TRUE(border >= 0.2 * bands && border <= 0.8 * bands) << border;
    }
  }
  EXPECT_EQ(noises, 20 * 4);  // an eighth of 32
  EXPECT_EQ(mixes, 20 * 4);
}

TEST(Outliers, AreNoisesOfManyColoursSteadyAndNot) {
  torch::manual_seed(5);
  const networks::Outliers outliers = made_outliers();
  const torch::Tensor labels = torch::zeros({2400}, torch::kInt64);
  const torch::Tensor drawn =
      outliers.draw({torch::full({2400, 1, bands, frames}, 2.0F)}, labels).front();
  ASSERT_EQ(drawn.size(0), 300);
  // Where the energy lies, and how much it swells and fades.
  const torch::Tensor power = torch::pow(10, 6 * (drawn - 1)).squeeze(1);
  const torch::Tensor of_bands = power.sum(2);
  const torch::Tensor middle =
      (of_bands * torch::arange(bands)).sum(1) / of_bands.sum(1).clamp_min(1e-9);
  EXPECT_LT(middle.quantile(0.1).item<float>(), 8);
  EXPECT_GT(middle.quantile(0.9).item<float>(), 30);
  const torch::Tensor over_time = power.sum(1).log10() * 10;
  // None breaks off.
  EXPECT_GT((over_time.select(1, frames - 1) - over_time.amax(1)).min().item<float>(), -50);
  const torch::Tensor swing = over_time.amax(1) - over_time.amin(1);
  EXPECT_LT(swing.quantile(0.1).item<float>(), 4);
  EXPECT_GT(swing.quantile(0.8).item<float>(), 10);
}

TEST(Outliers, OfSeveralModalitiesAreOneSoundInEach) {
  torch::manual_seed(2);
  const networks::Outliers outliers(
      made_method({learning::Branch::isnn, learning::Branch::soundnet5}),
      learning::paper_format(22050, 22050));
  const torch::Tensor labels = torch::tensor({0, 1}, torch::kInt64).repeat({16});
  const torch::Tensor level = (labels + 2).to(torch::kFloat32);
  const auto drawn = outliers.draw({level.view({32, 1, 1, 1}).expand({32, 1, bands, frames}),
                                    level.view({32, 1, 1}).expand({32, 1, 22050})},
                                   labels);
  ASSERT_EQ(drawn.size(), 2U);
  ASSERT_EQ(drawn[0].size(0), drawn[1].size(0));
  ASSERT_EQ(drawn[1].size(0), 8);
  for (std::int64_t i = 0; i < drawn[1].size(0); ++i) {
    const torch::Tensor wave = drawn[1][i][0];
    if (i < 4) {  // noises, with a peak of 1
      EXPECT_NEAR(wave.abs().max().item<float>(), 1, 1e-6);
      continue;
    }
    // The earlier part of the sound whose low bands are in the spectrogram.
    const float first = wave[0].item<float>(), last = wave[22049].item<float>();
    EXPECT_EQ(first, drawn[0][i][0][0][0].item<float>());
    EXPECT_EQ(first + last, 5);
    const auto border = wave.eq(first).sum().item<std::int64_t>();
    EXPECT_TRUE(wave.slice(0, 0, border).eq(first).all().item<bool>());
    EXPECT_TRUE(border >= 22050 / 5 && border <= 22050 * 4 / 5) << border;
  }
}

TEST(Outliers, LeaveNoSoundAsItWasWhereItsHighBandsAreEmpty) {
  torch::manual_seed(3);
  const torch::Tensor labels = torch::tensor({0, 1}, torch::kInt64).repeat({16});
  torch::Tensor batch = (labels + 2).to(torch::kFloat32).view({32, 1, 1, 1});
  batch = batch.expand({32, 1, bands, frames}).clone();
  batch.slice(2, 8) = 0;
  const torch::Tensor drawn = made_outliers().draw({batch}, labels).front();
  for (std::int64_t i = 4; i < 8; ++i) {
    const torch::Tensor low = drawn[i][0].slice(0, 0, 8);
    EXPECT_EQ(low.min().item<float>(), 2) << i;
    EXPECT_EQ(low.max().item<float>(), 3) << i;
  }
}

TEST(Outliers, AreNoMixesOfSoundsOfWhichOneEndsBeforeTheOther) {
  torch::manual_seed(4);
  const networks::Outliers outliers(
      made_method({learning::Branch::isnn, learning::Branch::soundnet5}),
      learning::paper_format(22050, 22050));
  const torch::Tensor labels = torch::tensor({0, 1}, torch::kInt64).repeat({16});
  const torch::Tensor level = (labels + 2).to(torch::kFloat32);
  const torch::Tensor even = level.view({32, 1, 1, 1}).expand({32, 1, bands, frames});
  // Class 0 has decayed by 1,000 samples, class 1 begins to sound where it has.
  torch::Tensor waves = torch::ones({32, 1, 22050});
  const torch::Tensor first = labels.eq(0);
  waves.index_put_({first, torch::indexing::Slice(), torch::indexing::Slice(1000)}, 0);
  waves.index_put_({first.logical_not(), torch::indexing::Slice(), torch::indexing::Slice(0, 1000)},
                   0);
  EXPECT_EQ(outliers.draw({even, waves}, labels)[0].size(0), 4);
  EXPECT_EQ(outliers.draw({even, torch::zeros({32, 1, 22050})}, labels)[1].size(0), 4);
}

TEST(Outliers, OfABatchOfOneClassAreNoises) {
  const torch::Tensor batch = torch::full({3, 1, bands, frames}, 2.0F);
  const torch::Tensor drawn =
      made_outliers().draw({batch}, torch::zeros({3}, torch::kInt64)).front();
  ASSERT_EQ(drawn.size(0), 1);
  EXPECT_LE(drawn.max().item<float>(), 1);
}

TEST(Outliers, CostLeastWhereAllClassesAreEquallyLikely) {
  const torch::Tensor even = torch::zeros({2, 5}), sure = torch::tensor({{9.0F, 0.0F, 0.0F}});
  EXPECT_NEAR(networks::Outliers::loss(even).item<double>(), std::log(5), 1e-6);
  // By hand: log(e^9 + 2) - 3.
  EXPECT_NEAR(networks::Outliers::loss(sure).item<double>(), std::log(std::exp(9) + 2) - 3, 1e-5);
}

}  // namespace
}  // namespace carillon::eval
