#include "cli/recording.hpp"

#include <fmt/format.h>

#include "core/audio.hpp"
#include "core/error.hpp"

namespace carillon::cli {

ChannelClip read_channel(const std::string& file, int channel) {
  const core::AudioClip clip = core::read_audio(file);
  if (channel < 1 || channel > clip.channels) {
    throw core::InputError(fmt::format("{} has {} channel{}, not {}", file, clip.channels,
                                       clip.channels == 1 ? "" : "s", channel),
                           "--channel counts from 1");
  }
  ChannelClip one{{}, static_cast<double>(clip.sample_rate)};
  for (auto i = static_cast<std::size_t>(channel - 1); i < clip.samples.size();
       i += static_cast<std::size_t>(clip.channels)) {
    one.samples.push_back(clip.samples[i]);
  }
  return one;
}

}  // namespace carillon::cli
