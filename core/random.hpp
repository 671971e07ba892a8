#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace carillon::core {

/// Random numbers that depend only on (seed, item, purpose) and on how many were drawn before:
/// the counter-based generator Philox4x64-10 (Salmon et al. 2011, Random123). Ranks and order of
/// work therefore never change a value, and seed 0 is a seed like any other.
class RandomStream {
 public:
  /// @param seed     dataset seed
  /// @param item     sample or object id (a stable hash of its name, for instance)
  /// @param purpose  what the numbers are for, e.g. "strike.position"; streams never overlap
  RandomStream(std::uint64_t seed, std::uint64_t item, std::string_view purpose);

  std::uint64_t next();
  /// Uniform in [0, 1), 53 bits.
  double uniform();
  /// Uniform in [low, high).
  double uniform(double low, double high);
  /// Uniform in the logarithm; both bounds positive.
  double log_uniform(double low, double high);
  /// Standard normal (Box-Muller, one value per call).
  double normal();
  /// Fills `values` with standard normals (ziggurat of Boost.Random): several times as fast as
  /// `normal()`, whose numbers these are not.
  void normals(std::span<double> values);
  /// Uniform integer in [0, n); n > 0.
  std::uint64_t index(std::uint64_t n);

 private:
  std::uint64_t key_[2];
  std::uint64_t counter_[4];
  std::uint64_t block_[4];
  int used_ = 4;
};

/// 64-bit hash of a text that never changes between machines or versions (first bytes of SHA-256).
std::uint64_t stable_hash(std::string_view text);

}  // namespace carillon::core
