#include "dataset/stored/sample_audio.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::dataset::stored {

namespace {

core::Hdf5Rows sounds_of(const core::Hdf5Group& index) {
  if (!index.has("audio")) throw core::InputError("the dataset has no sounds");
  return {index, "audio"};
}

}  // namespace

SampleAudio::SampleAudio(const core::Hdf5Group& index) : rows_(sounds_of(index)) {
  format_ = index.element_type("audio") == "int16" ? core::SampleFormat::int16
                                                   : core::SampleFormat::float32;
  sample_rate_ = static_cast<int>(std::lround(index.number_attribute("sample_rate_hz")));
  const core::Extent& extent = rows_.extent();
  if (extent.size() == 3) listeners_ = extent[1];
  samples_ = extent.back();
}

std::vector<core::AudioClip> SampleAudio::read(std::uint64_t first, std::uint64_t count) const {
  std::vector<float> all;
  if (format_ == core::SampleFormat::int16) {
    const auto stored = rows_.read<std::int16_t>(first, count);
    all.resize(stored.size());
    std::transform(stored.begin(), stored.end(), all.begin(), [](std::int16_t value) {
      return static_cast<float>(value) / core::int16_full_scale;
    });
  } else {
    all = rows_.read<float>(first, count);
  }
  std::vector<core::AudioClip> clips;
  const float* from = all.data();
  for (std::uint64_t row = 0; row < count; ++row, from += listeners_ * samples_) {
    core::AudioClip clip{std::vector<float>(listeners_ * samples_), static_cast<int>(listeners_),
                         sample_rate_};
    for (std::size_t l = 0; l < listeners_; ++l) {
      for (std::size_t i = 0; i < samples_; ++i) {
        clip.samples[i * listeners_ + l] = from[l * samples_ + i];
      }
    }
    clips.push_back(std::move(clip));
  }
  return clips;
}

}  // namespace carillon::dataset::stored
