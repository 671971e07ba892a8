#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace carillon::eval {

/// A damped sinusoid as tests make it: a exp(-d t) cos(2 pi f t + phase).
struct Partial {
  double frequency = 1000;
  double decay_rate = 10;
  double amplitude = 1;
  double phase = 0;
};

/// A generator of its own for tests: shares nothing with the program.
class TestRandom {
 public:
  explicit TestRandom(std::uint64_t seed) : state_(seed * 2654435761u + 12345) {}
  double uniform();
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double normal();

 private:
  std::uint64_t state_;
};

struct ClipShape {
  double sample_rate = 44100;
  double seconds = 1;
  double onset = 0;  ///< [s]; silence (and noise) before
};

/// A plain sum over partials from the onset on.
std::vector<double> strike_clip(std::span<const Partial> partials, const ClipShape& shape);

/// A strike in a room: direct sound and noise that decays, which each mode rings in.
std::vector<double> strike_in_room(std::span<const Partial> partials, const ClipShape& shape,
                                   double rt60, TestRandom& random);

/// Adds white noise at a ratio to the mean power of the 100 ms after the onset.
/// @return its standard deviation
double add_noise(std::vector<double>& samples, const ClipShape& shape, double snr_db,
                 TestRandom& random);

/// Cramer-Rao bounds of frequency [Hz] and decay rate [1/s] of every partial in white noise, from
/// `from` seconds after the onset on, by the Fisher information of the sampled signal.
struct Bound {
  double frequency = 0;
  double decay_rate = 0;
};
std::vector<Bound> cramer_rao(std::span<const Partial> partials, const ClipShape& shape,
                              double from, double noise);

}  // namespace carillon::eval
