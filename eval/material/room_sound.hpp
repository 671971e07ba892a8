#pragma once

#include <optional>
#include <span>
#include <vector>

#include "eval/damping/damping_data.hpp"
#include "eval/material/heard_tones.hpp"

namespace carillon::eval::material {

/// Decay rates that a room gives to what is heard in it, by frequency.
class RoomSound {
 public:
  /// Of a known room.
  /// @param rt60  by octave from 125 Hz on [s], the last one holds above; not empty; 0: no room
  explicit RoomSound(std::span<const double> rt60);

  /// Of an unknown room, from a recording in it. A room answers a tone with many that are spread
  /// about it, and these decay like the room whatever the object does. There is one where features
  /// that are no mode's are many: 20, and three for every one that is; and where their decay rates
  /// are a room's: within a factor of 3 of each other (one standard deviation).
  /// @param heads  features that are modes'
  RoomSound(const features::FeatureSet& set, std::span<const std::size_t> heads);

  bool heard() const { return !log_rates_.empty() || !rt60_.empty(); }
  /// Median of the decay rates of what a room makes of a tone, which is 1.6 times its mean energy's
  /// ln(1000) / RT60 (measured, docs/material-estimation.md): at the 15 features nearest to a
  /// frequency [1/s]; infinite: no room.
  double rate_at(double frequency) const;
  /// Reverberation time of all of them together [s]; none without a room.
  std::optional<double> rt60() const;

 private:
  std::vector<double> rt60_;  // known
  std::vector<double> log_frequencies_, log_rates_;
};

/// The feature that tells the damping of a mode heard in a room: the slowest of those within 20
/// cents of the mode's strongest, at most 10 dB weaker and exact within 6 %. The strongest is often
/// what the room makes of the strike.
/// @param heads  strongest features of all modes: none is another's, and a feature in the lines of
///               two is that of the nearer one
const features::Feature& slowest_in_line(const features::FeatureSet& set, std::size_t head,
                                         std::span<const std::size_t> heads);

/// What the damping of matched modes is fitted to.
struct DampingPoints {
  damping::DampingData data;
  std::vector<double> rooms;   ///< c of the room at each [1/s]; infinite: none
  std::optional<double> rt60;  ///< of the most reverberant room [s]; none: no room is heard
};

/// One point for every mode, of the recording that knows its decay rate best: another microphone
/// hears the same mode, and the same recording twice tells nothing new.
/// @param modes  for each its features, of one recording or several
/// @param rt60   of the room, as RoomSound's; empty: not known
DampingPoints damping_points(std::span<const features::FeatureSet> recordings,
                             std::span<const std::vector<FeatureIndex>> modes,
                             std::span<const double> rt60);

}  // namespace carillon::eval::material
