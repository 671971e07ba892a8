#include "eval/networks/detail/outliers.hpp"

#include "core/random.hpp"
#include "synth/recording/noise_generators.hpp"

namespace carillon::eval::networks {

namespace {

/// Kinds of noise that are learnt from; brown noise and babble are kept for the trial.
constexpr synth::recording::NoiseKind learnt_kinds[] = {synth::recording::NoiseKind::white,
                                                        synth::recording::NoiseKind::pink,
                                                        synth::recording::NoiseKind::hum};
constexpr std::size_t of_each_kind = 200;

/// Of each a mix has no less and no more than so.
constexpr double min_fraction = 0.2, greatest_fraction = 0.8;

/// What each has up to each band of spectrograms, or each sample of waveforms, as shares: rows x
/// size.
torch::Tensor shares_below(const torch::Tensor& sounds) {
  const bool has_frames = sounds.dim() == 4;
  const torch::Tensor strength = has_frames ? sounds.sum({1, 3}) : sounds.square().sum(1);
  const torch::Tensor below = strength.cumsum(1);
  return below / below.slice(1, -1);
}

/// Where one sound's lower part and another's upper part are a fraction of either: rows x size.
torch::Tensor borders_between(const torch::Tensor& first, const torch::Tensor& second) {
  const auto within = [](const torch::Tensor& fraction) {
    return fraction.ge(min_fraction).logical_and(fraction.le(greatest_fraction));
  };
  return within(shares_below(first)).logical_and(within(shares_below(second)));
}

/// Up to a border, drawn from those there may be, the first; above it the second.
torch::Tensor mixed(const torch::Tensor& first, const torch::Tensor& second,
                    const torch::Tensor& borders) {
  const torch::Tensor border = torch::multinomial(borders.to(torch::kFloat32), 1);
  torch::Tensor of_first = torch::arange(borders.size(1)).unsqueeze(0).le(border).unsqueeze(1);
  if (first.dim() == 4) of_first = of_first.unsqueeze(3);
  return torch::where(of_first, first, second);
}

}  // namespace

Outliers::Outliers(const learning::Method& method, const learning::ClipFormat& format) {
  const learning::ClipPreparer preparer(format);
  for (const learning::Modality modality : method.modalities) {
    const learning::ModalityExtent extent = preparer.extent(modality);
    std::vector<std::int64_t> all = {
        static_cast<std::int64_t>(of_each_kind * std::size(learnt_kinds))};
    all.insert(all.end(), extent.begin(), extent.end());
    noises_.push_back(torch::zeros(all));
  }
  std::int64_t row = 0;
  for (const synth::recording::NoiseKind kind : learnt_kinds) {
    for (std::size_t i = 0; i < of_each_kind; ++i, ++row) {
      core::RandomStream random(
          1, i, synth::recording::noise_kind_names().at(static_cast<std::size_t>(kind)));
      const auto noise =
          synth::recording::generate_noise(kind, format.samples, format.sample_rate(), random);
      const std::vector<float> clip(noise.begin(), noise.end());
      for (std::size_t s = 0; s < method.modalities.size(); ++s) {
        torch::Tensor values = noises_[s][row];
        const std::span<float> input(values.data_ptr<float>(),
                                     static_cast<std::size_t>(values.numel()));
        preparer.prepare(method.modalities[s], clip, input);
        if (method.modalities[s] == learning::Modality::spectrogram)
          method.spectrogram.apply(input);
      }
    }
  }
}

std::vector<torch::Tensor> Outliers::draw(const std::vector<torch::Tensor>& modalities,
                                          const torch::Tensor& labels) const {
  const std::int64_t samples = labels.size(0);
  const std::int64_t count = std::max<std::int64_t>(1, samples / 8);
  const torch::Tensor noise = torch::randint(noises_.front().size(0), {count});
  std::vector<torch::Tensor> drawn;
  for (const torch::Tensor& noises : noises_) drawn.push_back(noises.index({noise}));
  const torch::Tensor first = torch::randint(samples, {count});
  const torch::Tensor differ =
      labels.index({first}).unsqueeze(1).ne(labels.unsqueeze(0)).to(torch::kFloat32);
  if (!differ.any().item<bool>()) return drawn;
  const torch::Tensor second = torch::multinomial(differ, 1).squeeze(1);
  std::vector<torch::Tensor> borders;
  torch::Tensor mixes = torch::ones({count}, torch::kBool);
  for (const torch::Tensor& modality : modalities) {
    borders.push_back(borders_between(modality.index({first}), modality.index({second})));
    mixes = mixes.logical_and(borders.back().any(1));
  }
  if (!mixes.any().item<bool>()) return drawn;
  const torch::Tensor lower = first.index({mixes}), upper = second.index({mixes});
  for (std::size_t s = 0; s < modalities.size(); ++s) {
    drawn[s] =
        torch::cat({drawn[s], mixed(modalities[s].index({lower}), modalities[s].index({upper}),
                                    borders[s].index({mixes}))});
  }
  return drawn;
}

torch::Tensor Outliers::loss(const torch::Tensor& logits) {
  return -torch::log_softmax(logits, 1).mean(1).mean();
}

}  // namespace carillon::eval::networks
