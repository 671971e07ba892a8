#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/play/event_reader.hpp"
#include "core/audio.hpp"
#include "synth/live/player.hpp"

namespace carillon::cli::play {

/// How long is played, and in what steps.
struct Pace {
  std::size_t block = 256;   ///< samples of a row
  double latency = 0.05;     ///< that an output holds back beside the block [s]
  bool clock = true;         ///< in real time; false: as quickly as the reader takes it
  double seconds = 0;        ///< 0: until it is stopped
  bool ends_silent = false;  ///< once the events have ended and nothing rings
  core::SampleFormat format = core::SampleFormat::float32;
};

/// What came of it.
struct Heard {
  std::uint64_t dropouts = 0;  ///< blocks that came too late
  double latest = 0;           ///< the worst of them [s]
  double behind = 0;           ///< by which all of them have put the sound off [s]
  bool reader_closed = false;
  double processor_seconds = 0;  ///< of the thread that played, while it did
  double voice_samples = 0;      ///< of partials, summed
};

/// Writes raw samples, frames of all rows, to a descriptor. A block that a clock asked for earlier
/// than it was written is a dropout; the clock goes on from there.
/// @param events  followed by the output: without a clock no block is played before its events
///                are known; may be null
Heard play_to_stream(synth::live::Player& player, int stream, const Pace& pace,
                     EventReader* events);

/// The same, into a WAV file.
/// @throws FileError
Heard play_to_file(synth::live::Player& player, const std::string& path, const Pace& pace,
                   EventReader* events);

/// Waits while something else plays (a device), until it ends as `pace` says.
void follow(synth::live::Player& player, const Pace& pace, EventReader* events);

}  // namespace carillon::cli::play
