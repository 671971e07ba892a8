#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "synth/modal/modal_response.hpp"

namespace carillon::synth::modal {

/// Samples summed at once: they fit the first-level cache, and the rounding of the recursion, which
/// grows with them, stays near 1e-13.
inline constexpr std::size_t block_size = 512;
/// Most samples in one vector.
inline constexpr std::size_t max_lanes = 8;
inline constexpr std::size_t step_powers = 10;

/// Sums of one block.
struct alignas(128) SampleBlock {
  std::array<double, block_size> samples;
};

/// How a partial goes on from sample to sample: powers of its step exp((-d + i omega) / rate).
struct alignas(64) Rotation {
  std::array<double, max_lanes> real;  ///< step^k
  std::array<double, max_lanes> imag;
  std::array<std::complex<double>, step_powers> powers;  ///< step^(2^j), up to a block
};

/// @param angular_frequency  [rad/s]; extended, so that hours keep their phase
Rotation make_rotation(double decay_rate, long double angular_frequency, double sample_rate);

/// exp((-d + i omega) t) of a partial, its phase reduced in extended precision: after a minute at
/// 20 kHz it is 7e6 rad, which a double holds to 1e-9 only.
std::complex<double> exponential(double decay_rate, long double angular_frequency, long double t);

/// A partial that rings: the real part of its value is its next sample.
struct Voice {
  const Rotation* rotation;
  std::complex<double> value;
};

/// Adds the voices' next `count` <= block_size samples; what lies beyond in the block is spoilt.
///
/// Lanes are consecutive samples: a vector follows from the two before it by the recursion
/// y[n + 2 w] = 2 Re(step^w) y[n + w] - |step^w|^2 y[n], whose first two are exact. Voices are
/// added in their order whatever the vector's width; kinds of CPU differ by rounding alone (1e-13
/// of the sum). Numbers below the normal range (1e-308) count as zero, as they are slow.
void add_voices(std::span<const Voice> voices, std::size_t count, SampleBlock& block);

/// Moves voices on by `count` samples, at most block_size.
void move_on(std::span<Voice> voices, std::size_t count);

/// Takes out voices whose magnitude, which bounds all they can still add, is below a level or zero;
/// the others keep their order.
void drop_below(double level, std::vector<Voice>& voices);

/// Writes a block as floats.
/// @param samples  at most block_size
/// @return largest magnitude among them, before rounding
double store_block(const SampleBlock& block, std::span<float> samples);

/// Largest magnitude among the first `count` samples of a block.
double peak_of(const SampleBlock& block, std::size_t count);

}  // namespace carillon::synth::modal
