#pragma once

#include <string>
#include <vector>

namespace carillon::cli {

/// One channel of an audio file.
struct ChannelClip {
  std::vector<double> samples;  ///< full scale 1
  double sample_rate = 0;       ///< [Hz]
};

/// @param channel  from 1
/// @throws FileError   not readable
/// @throws InputError  a channel that the file does not have; names the file
ChannelClip read_channel(const std::string& file, int channel);

}  // namespace carillon::cli
