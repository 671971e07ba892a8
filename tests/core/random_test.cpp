#include "core/random.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Random123/philox.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "core/hash.hpp"

namespace carillon::core {
namespace {

using Block = std::array<std::uint64_t, 4>;
using Key = std::array<std::uint64_t, 2>;

__extension__ using Wide = unsigned __int128;

/// Philox4x64-10 as in Salmon et al. 2011, section 3.3, written a second time for comparison.
Block philox(Block counter, Key key) {
  for (int round = 0; round < 10; ++round) {
    const Wide a = Wide(0xD2E7470EE14C6C93) * counter[0];
    const Wide b = Wide(0xCA5A826395121157) * counter[2];
    counter = {std::uint64_t(b >> 64) ^ counter[1] ^ key[0], std::uint64_t(b),
               std::uint64_t(a >> 64) ^ counter[3] ^ key[1], std::uint64_t(a)};
    key[0] += 0x9E3779B97F4A7C15;
    key[1] += 0xBB67AE8584CAA73B;
  }
  return counter;
}

struct KnownAnswer {
  Block counter;
  Key key;
  Block answer;
};

// Random123's published known answers (kat_vectors, philox4x64 10).
const std::vector<KnownAnswer> known_answers = {
    {{0, 0, 0, 0},
     {0, 0},
     {0x16554d9eca36314c, 0xdb20fe9d672d0fdc, 0xd7e772cee186176b, 0x7e68b68aec7ba23b}},
    {{~0ULL, ~0ULL, ~0ULL, ~0ULL},
     {~0ULL, ~0ULL},
     {0x87b092c3013fe90b, 0x438c3c67be8d0224, 0x9cc7d7c69cd777b6, 0xa09caebf594f0ba0}},
    {{0x243f6a8885a308d3, 0x13198a2e03707344, 0xa4093822299f31d0, 0x082efa98ec4e6c89},
     {0x452821e638d01377, 0xbe5466cf34e90c6c},
     {0xa528f45403e61d95, 0x38c72dbd566e9788, 0xa5a1610e72fd18b5, 0x57bd43b5e52b7fe6}}};

TEST(Philox, GivesThePublishedAnswers) {
  for (const KnownAnswer& known : known_answers) {
    EXPECT_EQ(philox(known.counter, known.key), known.answer);
    const r123::Philox4x64::ctr_type counter = {
        {known.counter[0], known.counter[1], known.counter[2], known.counter[3]}};
    const r123::Philox4x64::key_type key = {{known.key[0], known.key[1]}};
    const auto block = r123::Philox4x64()(counter, key);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(block[i], known.answer[i]);
  }
}

TEST(RandomStream, IsPhiloxOverBlockAndItemKeyedBySeedAndPurpose) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed, std::uint64_t item, const std::string& purpose) {
    RandomStream stream(seed, item, purpose);
    const Key key = {seed, stable_hash(purpose)};
    for (std::uint64_t block = 0; block < 3; ++block) {
      for (std::uint64_t value : philox({block, item, 0, 0}, key))
        RC_ASSERT(stream.next() == value);
    }
  }));
}

TEST(RandomStream, StreamsOfOtherSeedsItemsAndPurposesShareNothing) {
  std::set<std::uint64_t> values;
  for (std::uint64_t seed : {0, 1}) {
    for (std::uint64_t item : {0, 1, 2}) {
      for (const char* purpose : {"strike.position", "strike.force", ""}) {
        RandomStream stream(seed, item, purpose);
        for (int i = 0; i < 100; ++i) values.insert(stream.next());
      }
    }
  }
  EXPECT_EQ(values.size(), 2u * 3 * 3 * 100);
}

TEST(RandomStream, UniformHas53BitsBelowOne) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    RandomStream bits(seed, 3, "bits"), stream(seed, 3, "bits");
    const double value = stream.uniform();
    RC_ASSERT(value >= 0.0 && value < 1.0);
    RC_ASSERT(value * 0x1p53 == static_cast<double>(bits.next() >> 11));
  }));
}

/// Largest distance between the values' distribution and `cdf` (Kolmogorov-Smirnov).
template <class Cdf>
double distance(std::vector<double> values, const Cdf& cdf) {
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  double worst = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double expected = cdf(values[i]);
    const auto rank = static_cast<double>(i);
    worst = std::max({worst, expected - rank / n, (rank + 1) / n - expected});
  }
  return worst;
}

constexpr int draws = 100'000;
// Passed by a true sample in 999 of 1000 seeds; the seed is fixed.
const double largest_distance = 1.95 / std::sqrt(draws);

template <class Draw>
std::vector<double> sample(const Draw& draw) {
  RandomStream stream(2024, 11, "distribution");
  std::vector<double> values(draws);
  for (double& value : values) value = draw(stream);
  return values;
}

TEST(RandomStream, DistributionsAreTheStatedOnes) {
  EXPECT_LT(distance(sample([](RandomStream& s) { return s.uniform(-2.0, 6.0); }),
                     [](double x) { return (x + 2) / 8; }),
            largest_distance);
  EXPECT_LT(distance(sample([](RandomStream& s) { return s.log_uniform(0.01, 100.0); }),
                     [](double x) { return std::log(x / 0.01) / std::log(1e4); }),
            largest_distance);
  EXPECT_LT(distance(sample([](RandomStream& s) { return s.normal(); }),
                     [](double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }),
            largest_distance);
}

TEST(RandomStream, ManyNormalsAtOnceAreNormalAndUncorrelated) {
  std::vector<double> values(draws);
  RandomStream(2024, 12, "distribution").normals(values);
  double lag = 0;
  for (int i = 1; i < draws; ++i) lag += values[std::size_t(i)] * values[std::size_t(i) - 1];
  EXPECT_LT(std::abs(lag / draws), 4 / std::sqrt(draws));
  // Beyond the ziggurat's outermost layer (3.44) another method takes over: 58 +- 8 are expected.
  const auto far = std::count_if(values.begin(), values.end(),
                                 [](double value) { return std::abs(value) > 3.4426; });
  EXPECT_NEAR(double(far), draws * std::erfc(3.4426 / std::sqrt(2.0)), 30);
  EXPECT_LT(distance(values, [](double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }),
            largest_distance);
}

TEST(RandomStream, ManyNormalsAreThoseOfTheirStreamAlone) {
  std::vector<double> first(100), again(100), other(100), longer(150);
  RandomStream(1, 2, "a").normals(first);
  RandomStream(1, 2, "a").normals(again);
  RandomStream(1, 2, "b").normals(other);
  RandomStream(1, 2, "a").normals(longer);
  EXPECT_EQ(first, again);
  EXPECT_NE(first, other);
  longer.resize(100);
  EXPECT_EQ(first, longer);
}

TEST(RandomStream, BoundsHoldEvenWhereRoundingReachesThem) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    RandomStream stream(seed, 0, "bounds");
    const double narrow = std::nextafter(std::nextafter(1.0, 2.0), 2.0);
    for (int i = 0; i < 20; ++i) {
      const double value = stream.uniform(1.0, narrow);
      RC_ASSERT(value >= 1.0 && value < narrow);
      const double ratio = stream.log_uniform(3.0, 3.0000000000000013);
      RC_ASSERT(ratio >= 3.0 && ratio < 3.0000000000000013);
    }
  }));
  RandomStream stream(0, 0, "point");
  EXPECT_EQ(stream.uniform(5.0, 5.0), 5.0);
  EXPECT_EQ(stream.log_uniform(5.0, 5.0), 5.0);
  EXPECT_THROW(stream.log_uniform(0.0, 1.0), std::invalid_argument);
}

TEST(RandomStream, EachCallTakesOneValueSoThatLaterDrawsKeepTheirPlace) {
  // A range that is a single value must not shift what is drawn after it.
  RandomStream point(1, 2, "order"), wide(1, 2, "order");
  point.uniform(1.0, 1.0);
  wide.uniform(1.0, 2.0);
  EXPECT_EQ(point.next(), wide.next());
  point.log_uniform(1.0, 1.0);
  wide.log_uniform(1.0, 2.0);
  EXPECT_EQ(point.next(), wide.next());
}

TEST(RandomStream, IndexIsEquallyLikely) {
  RandomStream stream(5, 0, "index");
  std::array<int, 7> counts{};
  for (int i = 0; i < 70'000; ++i) ++counts[stream.index(7)];
  double chi_squared = 0;
  for (int count : counts) chi_squared += (count - 1e4) * (count - 1e4) / 1e4;
  EXPECT_LT(chi_squared, 22.46);  // 6 degrees of freedom, 1 in 1000

  // With a plain remainder the first third would be drawn twice as often as the others.
  const std::uint64_t n = 3ULL << 62;
  int low = 0;
  for (int i = 0; i < 30'000; ++i) low += stream.index(n) < (1ULL << 62);
  EXPECT_NEAR(low, 10'000, 270);  // 3.3 standard deviations
  EXPECT_EQ(stream.index(1), 0u);
  EXPECT_THROW(stream.index(0), std::invalid_argument);
}

TEST(StableHash, IsTheFirstBytesOfSha256) {
  // FIPS 180-2's "abc" begins with ba7816bf8f01cfea.
  EXPECT_EQ(stable_hash("abc"), 0xba7816bf8f01cfeaULL);
  EXPECT_EQ(stable_hash(""), 0xe3b0c44298fc1c14ULL);
}

}  // namespace
}  // namespace carillon::core
