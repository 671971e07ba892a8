#include "eval/networks/detail/outliers.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/random.hpp"
#include "eval/networks/detail/equaliser.hpp"
#include "synth/recording/noise_generators.hpp"

namespace carillon::eval::networks {

namespace {

constexpr std::size_t coloured_noises = 450, hums = 150;

torch::Tensor normals(std::int64_t count, core::RandomStream& random) {
  torch::Tensor values = torch::empty({count}, torch::kFloat64);
  random.normals({values.data_ptr<double>(), static_cast<std::size_t>(count)});
  return values;
}

torch::Tensor drawn_curve(std::int64_t knots, std::int64_t count, double deviation,
                          core::RandomStream& random) {
  return curves_through(deviation * normals(knots, random).view({1, 1, knots}), count)
      .view({count});
}

/// Noise of a drawn colour: from a drawn corner on it falls by up to 15 dB per octave, or rises by
/// 3, with hills and valleys of 6 dB; three of four swell and fade some times a second, by 2 to
/// 12 dB.
std::vector<double> coloured_noise(std::size_t samples, double sample_rate,
                                   core::RandomStream& random) {
  const auto count = static_cast<std::int64_t>(samples);
  const std::int64_t lines = count / 2 + 1;
  const double line = sample_rate / static_cast<double>(count);
  const torch::Tensor octaves =  // above 20 Hz
      (torch::arange(lines, torch::kFloat64) * line).clamp_min(20.0).div(20.0).log2();
  const double corner = random.uniform(0, 7.5);
  torch::Tensor level = random.uniform(-15, 3) * (octaves - corner).clamp_min(0);  // [dB]
  const torch::Tensor hills = drawn_curve(12, 1000, 6, random);
  level += hills.index({(octaves / octaves[-1] * 999).to(torch::kInt64)});
  const double decibels = std::log(10.0) / 20;
  torch::Tensor noise = torch::fft::irfft(
      torch::fft::rfft(normals(count, random)) * torch::exp(level * decibels), count);
  if (random.uniform() < 0.75) {
    const double seconds = static_cast<double>(samples) / sample_rate;
    const auto knots = static_cast<std::int64_t>(2 + std::ceil(seconds * random.uniform(2, 12)));
    const double depth = random.uniform(2, 12);
    noise = noise * torch::exp(drawn_curve(knots, count, depth, random) * decibels);
  }
  noise = noise.contiguous();
  return {noise.data_ptr<double>(), noise.data_ptr<double>() + count};
}

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

namespace {

/// Of each modality, noises x extent.
std::vector<torch::Tensor> made_noises(const learning::Method& method,
                                       const learning::ClipFormat& format) {
  std::vector<torch::Tensor> noises;
  const learning::ClipPreparer preparer(format);
  for (const learning::Modality modality : method.modalities) {
    const learning::ModalityExtent extent = preparer.extent(modality);
    std::vector<std::int64_t> all = {static_cast<std::int64_t>(coloured_noises + hums)};
    all.insert(all.end(), extent.begin(), extent.end());
    noises.push_back(torch::zeros(all));
  }
  for (std::size_t i = 0; i < coloured_noises + hums; ++i) {
    core::RandomStream random(1, i, "outliers");
    const std::size_t samples = learning::noise_lengths * format.samples;
    const std::vector<double> noise =
        i < coloured_noises
            ? coloured_noise(samples, format.sample_rate(), random)
            : synth::recording::generate_noise(synth::recording::NoiseKind::hum, samples,
                                               format.sample_rate(), random);
    const std::vector<float> clip = learning::noise_clip(noise, format);
    for (std::size_t s = 0; s < method.modalities.size(); ++s) {
      torch::Tensor values = noises[s][static_cast<std::int64_t>(i)];
      const std::span<float> input(values.data_ptr<float>(),
                                   static_cast<std::size_t>(values.numel()));
      preparer.prepare(method.modalities[s], clip, input);
      if (method.modalities[s] == learning::Modality::spectrogram) method.spectrogram.apply(input);
    }
  }
  return noises;
}

}  // namespace

Outliers::Outliers(const learning::Method& method, const learning::ClipFormat& format) {
  // They know no seed and no task: trainings one after the other share them.
  static std::map<std::string, std::vector<torch::Tensor>> made;
  const nlohmann::ordered_json of_method = learning::to_json(method);
  const std::string key = learning::to_json(format).dump() + of_method.at("modalities").dump() +
                          of_method.at("spectrogram").dump();
  const auto [found, fresh] = made.try_emplace(key);
  if (fresh) found->second = made_noises(method, format);
  noises_ = found->second;
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
