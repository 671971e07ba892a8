#include "core/random.hpp"

#include <Random123/philox.h>

#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "core/hash.hpp"

namespace carillon::core {

namespace {

/// A stream as the distributions of other libraries want it.
struct Bits {
  using result_type = std::uint64_t;
  RandomStream& stream;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }
  result_type operator()() const { return stream.next(); }
};

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t item, std::string_view purpose)
    : key_{seed, stable_hash(purpose)}, counter_{0, item, 0, 0}, block_{} {}

std::uint64_t RandomStream::next() {
  if (used_ == 4) {
    const r123::Philox4x64::ctr_type counter = {
        {counter_[0], counter_[1], counter_[2], counter_[3]}};
    const r123::Philox4x64::key_type key = {{key_[0], key_[1]}};
    const auto block = r123::Philox4x64()(counter, key);
    for (int i = 0; i < 4; ++i) block_[i] = block[i];
    ++counter_[0];
    used_ = 0;
  }
  return block_[used_++];
}

double RandomStream::uniform() {
  return static_cast<double>(next() >> 11) * 0x1p-53;
}

double RandomStream::uniform(double low, double high) {
  const double value = low + (high - low) * uniform();
  // Rounding can reach the upper bound, which the interval leaves out.
  return value < high || !(low < high) ? value : std::nextafter(high, low);
}

double RandomStream::log_uniform(double low, double high) {
  if (!(low > 0) || !(high > 0)) {
    throw std::invalid_argument("RandomStream::log_uniform: bounds must be positive");
  }
  if (low == high) {
    next();
    return low;
  }
  const double value = std::exp(uniform(std::log(low), std::log(high)));
  // exp(log(x)) may fall a rounding beside x.
  return value < low ? low : value < high ? value : std::nextafter(high, low);
}

double RandomStream::normal() {
  // 1 - u lies in (0, 1], so that the logarithm is finite.
  const double radius = std::sqrt(-2 * std::log(1 - uniform()));
  return radius * std::cos(2 * std::numbers::pi * uniform());
}

void RandomStream::normals(std::span<double> values) {
  Bits bits{*this};
  boost::random::normal_distribution<double> distribution;
  for (double& value : values) value = distribution(bits);
}

std::uint64_t RandomStream::index(std::uint64_t n) {
  if (n == 0) throw std::invalid_argument("RandomStream::index: n must be positive");
  // The lowest 2^64 mod n values are refused, so that every remainder is equally likely.
  const std::uint64_t refused = (0 - n) % n;
  std::uint64_t value = next();
  while (value < refused) value = next();
  return value % n;
}

std::uint64_t stable_hash(std::string_view text) {
  return std::stoull(sha256(text).substr(0, 16), nullptr, 16);
}

}  // namespace carillon::core
