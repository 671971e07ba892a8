// Spectrograms as through a drawn equaliser.
#include "eval/networks/detail/equaliser.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace carillon::eval {
namespace {

constexpr std::int64_t sounds = 40, rows = 64, columns = 25;

/// Each band decays at a rate of its own, from 0 dB down.
torch::Tensor decays() {
  const torch::Tensor slope = torch::linspace(0.5, 1.5, rows).view({1, 1, rows, 1});
  const torch::Tensor time = torch::arange(columns).to(torch::kFloat32).view({1, 1, 1, columns});
  return (-slope * time).expand({sounds, 1, rows, columns});  // [dB]
}

TEST(Equaliser, MovesBandsAndLeavesDecaysAsTheyAre) {
  torch::manual_seed(1);
  const learning::SpectrogramInput input{learning::SpectrogramScale::decibels, 60};
  const torch::Tensor before = 1 + decays() / 60;
  const torch::Tensor after = networks::equalised(before, input, 6);
  EXPECT_TRUE(torch::allclose(after.amax({1, 2, 3}), torch::ones({sounds})));
  // No band moves by more than 6 dB up and 6 down against another: nothing has fallen out of range.
  const torch::Tensor gain = 60 * (after - before);
  EXPECT_LE((gain.amax(3) - gain.amin(3)).abs().max().item<float>(), 1e-3);
  const torch::Tensor of_bands = gain.amax({1, 3});
  const torch::Tensor spread = of_bands.amax(1) - of_bands.amin(1);
  EXPECT_LE(spread.max().item<float>(), 12.001);
  EXPECT_GT(spread.min().item<float>(), 0.5);
  // Every sample has a curve of its own, and over many of them no band is favoured.
  EXPECT_GT((of_bands[0] - of_bands[1]).abs().max().item<float>(), 0.5);
  const torch::Tensor level = of_bands - of_bands.mean(1, true);
  EXPECT_LT(level.mean(0).abs().max().item<float>(), 4 * 3.5 / std::sqrt(40.0));
}

TEST(Equaliser, DoesToPowersWhatItDoesToDecibels) {
  const learning::SpectrogramInput decibels{learning::SpectrogramScale::decibels, 60};
  const learning::SpectrogramInput power{learning::SpectrogramScale::power, 60};
  torch::manual_seed(2);
  const torch::Tensor one = networks::equalised(1 + decays() / 60, decibels, 6);
  torch::manual_seed(2);
  const torch::Tensor other =
      networks::equalised(torch::exp(decays() * (std::log(10.0) / 10)), power, 6);
  EXPECT_TRUE(torch::allclose(10 * other.log10(), 60 * (one - 1), 1e-4, 1e-3));
}

TEST(Equaliser, LeavesSilenceAndEmptyCellsEmpty) {
  torch::manual_seed(3);
  torch::Tensor input = 1 + decays().clone() / 60;
  input.slice(2, 0, 8) = 0;  // empty bands
  input[5] = 0;              // a silent clip
  for (const auto scale : learning::all_spectrogram_scales) {
    const torch::Tensor after = networks::equalised(input, {scale, 60}, 12);
    EXPECT_TRUE(torch::isfinite(after).all().item<bool>());
    EXPECT_EQ(after.slice(2, 0, 8).abs().max().item<float>(), 0);
    EXPECT_EQ(after[5].abs().max().item<float>(), 0);
    EXPECT_GE(after.min().item<float>(), 0);
  }
}

}  // namespace
}  // namespace carillon::eval
