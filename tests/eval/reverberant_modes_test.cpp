// Decay rates of modes in a room: the likelihood against the Gaussian process that it is of, the
// scatter of what is found against the Cramer-Rao bound, and modes that decay faster than the room.
#include "eval/damping/reverberant_modes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/damping/damping_data.hpp"
#include "eval/damping/detail/reverberant_line.hpp"
#include "tests/eval/strike_clip.hpp"

namespace carillon::eval::damping {
namespace {

using Complex = std::complex<double>;

/// dy = (-d + i omega) y dt + sqrt(q) exp(-delta t) dW at a rate, exactly.
struct DrivenMode {
  double omega = 0, decay_rate = 10, drive = 1, room_rate = 20, rate = 400;

  Complex turn() const { return std::exp(Complex(-decay_rate, omega) / rate); }
  /// Variance that the noise adds from t to the next sample.
  double added(double t) const {
    const double a = 2 * (decay_rate - room_rate);
    return drive * std::exp(-2 * room_rate * (t + 1 / rate)) *
           (a == 0 ? 1 / rate : -std::expm1(-a / rate) / a);
  }
};

Complex normal_pair(TestRandom& random, double variance) {
  return std::sqrt(variance / 2) * Complex(random.normal(), random.normal());
}

BandSignal drawn_band(const DrivenMode& mode, double direct, double noise, std::size_t count,
                      TestRandom& random) {
  BandSignal band{1000, mode.rate, 0, {}};
  Complex y = std::polar(std::sqrt(direct), 1.0);
  for (std::size_t n = 0; n < count; ++n) {
    band.samples.push_back(y + normal_pair(random, noise));
    y = mode.turn() * y + normal_pair(random, mode.added(static_cast<double>(n) / mode.rate));
  }
  return band;
}

TEST(ReverberantLine, MisfitIsThatOfTheGaussianProcess) {
  TestRandom random(3);
  for (const double d : {6.0, 20.0, 75.0}) {
    const DrivenMode mode{30, d, 2.5, 20, 400};
    const double noise = 0.01;
    const BandSignal band = drawn_band(mode, 1, noise, 40, random);
    // Given the first sample z: y0 = z + N(0, R).
    const auto count = static_cast<Eigen::Index>(band.samples.size()) - 1;
    Eigen::VectorXcd rest(count);
    Eigen::MatrixXcd covariance = Eigen::MatrixXcd::Identity(count, count) * noise;
    const auto turns = [&](Eigen::Index n) { return std::pow(mode.turn(), static_cast<int>(n)); };
    for (Eigen::Index m = 0; m < count; ++m) {
      rest[m] = band.samples[static_cast<std::size_t>(m) + 1] - turns(m + 1) * band.samples[0];
      for (Eigen::Index n = 0; n < count; ++n) {
        covariance(m, n) += noise * turns(m + 1) * std::conj(turns(n + 1));
        for (Eigen::Index k = 0; k <= std::min(m, n); ++k) {
          covariance(m, n) += mode.added(static_cast<double>(k) / mode.rate) * turns(m - k) *
                              std::conj(turns(n - k));
        }
      }
    }
    const Eigen::LLT<Eigen::MatrixXcd> factor(covariance);
    const double log_determinant = 2 * factor.matrixLLT().diagonal().real().array().log().sum();
    const double expected = log_determinant + rest.dot(factor.solve(rest)).real();
    const double at[4] = {mode.omega, std::log(d), std::log(mode.drive), std::log(noise)};
    EXPECT_NEAR(line_misfit(band, mode.room_rate, at), expected, 1e-8 * std::abs(expected)) << d;
  }
}

/// Standard error of ln d at best where nothing but the room is in the way: with a / q the power of
/// the direct sound over the noise's,
///   J = 2 integral of E|y|^2 exp(2 delta t) / q dt,
///   E|y|^2 = a exp(-2 d t) + q (exp(-2 delta t) - exp(-2 d t)) / (2 (d - delta)).
double cramer_rao_of_line(const DrivenMode& mode, double direct, double duration) {
  const double rate = 2 * (mode.room_rate - mode.decay_rate), x = rate * duration;
  const double once = std::expm1(x) / rate, twice = (std::expm1(x) - x) / (rate * rate);
  return 1 / (mode.decay_rate * std::sqrt(2 * (direct / mode.drive * once + twice)));
}

TEST(ReverberantLine, ScatterIsThatOfTheBound) {
  constexpr int draws = 120;
  const double duration = 0.3, direct = 1, drive = 54;
  for (const double d : {12.0, 40.0, 70.0}) {
    TestRandom random(7);
    const DrivenMode mode{20, d, drive, 23, 400};
    std::vector<double> off, size, stated;
    for (int draw = 0; draw < draws; ++draw) {
      const auto line = fit_line(
          drawn_band(mode, direct, 1e-7, static_cast<std::size_t>(duration * mode.rate), random),
          mode.room_rate);
      if (!line) continue;
      off.push_back(std::log(line->decay_rate / d));
      size.push_back(std::abs(off.back()));
      stated.push_back(line->decay_rate_error / line->decay_rate);
    }
    ASSERT_GT(off.size(), draws * 9 / 10) << d;
    const double bound = cramer_rao_of_line(mode, direct, duration);
    // Medians: where the tail happens to cancel the direct sound, a draw tells far less than the
    // bound's mean over draws, the more the slower the mode is.
    const double scatter = core::median(size) / 0.6745;
    EXPECT_GT(scatter, 0.8 * bound) << d;
    EXPECT_LT(scatter, 1.5 * bound) << d;
    EXPECT_NEAR(core::median(stated), scatter, 0.25 * scatter) << d;
    EXPECT_LT(std::abs(core::median(off)), 0.5 * bound) << d;
  }
}

std::vector<features::Feature> modes_in_room(std::span<const double> samples, double sample_rate,
                                             const features::FeatureOptions& options) {
  return reverberant_modes(samples, sample_rate, options).features;
}

TEST(ReverberantModes, FasterThanTheRoomAreFound) {
  const std::vector<Partial> partials = {{640, 3, 1, 1},   {1250, 9, 1, 2},  {2470, 16, 1, 3},
                                         {3900, 40, 1, 0}, {5200, 60, 1, 1}, {6500, 90, 1, 2}};
  const ClipShape shape{44100, 1, 0.05};
  constexpr int draws = 6;
  std::vector<int> times(partials.size(), 0);
  std::size_t near = 0, all = 0;
  for (int seed = 1; seed <= draws; ++seed) {
    TestRandom random(static_cast<std::uint64_t>(seed));
    std::vector<double> samples(static_cast<std::size_t>(shape.onset * shape.sample_rate), 0.0);
    const std::vector<double> sound = strike_in_room(partials, {44100, 1, 0}, 0.3, random);
    samples.insert(samples.end(), sound.begin(), sound.end());
    add_noise(samples, shape, 50, random);
    const auto modes = modes_in_room(samples, shape.sample_rate, {.rt60 = {0.3}, .min_level = -50});
    for (std::size_t k = 0; k < partials.size(); ++k) {
      const Partial& partial = partials[k];
      const auto found = std::find_if(modes.begin(), modes.end(), [&](const auto& mode) {
        return std::abs(mode.frequency - partial.frequency) < 15;
      });
      if (found == modes.end()) continue;
      ++times[k];
      ++all;
      if (std::abs(found->decay_rate - partial.decay_rate) < 2.5 * found->decay_rate_error) ++near;
      EXPECT_LT(found->decay_rate_error, 0.31 * found->decay_rate);
    }
    // What is no mode of the object is the room's.
    EXPECT_LE(modes.size(), partials.size() + 1);
  }
  // Of rates near the room's some draws tell too little.
  for (std::size_t k = 0; k < partials.size(); ++k) {
    EXPECT_GE(times[k], partials[k].decay_rate < 20 ? draws : draws / 2) << partials[k].decay_rate;
  }
  EXPECT_GE(near, all * 9 / 10);
}

/// Damped by 0.1 to 0.4 1/s in a room of 0.3 s: bells and forks, as long as the clip lasts.
TEST(ReverberantModes, SlowModesAreFound) {
  const std::vector<Partial> partials = {
      {440, 0.1, 1, 1}, {1100, 0.2, 1, 2}, {2330, 0.3, 1, 3}, {4100, 0.4, 1, 0}};
  for (int seed = 1; seed <= 3; ++seed) {
    TestRandom random(static_cast<std::uint64_t>(seed));
    const ClipShape shape{44100, 2, 0};
    std::vector<double> samples = strike_in_room(partials, shape, 0.3, random);
    add_noise(samples, shape, 60, random);
    const auto set = reverberant_modes(samples, shape.sample_rate, {.rt60 = {0.3}});
    ASSERT_EQ(set.features.size(), partials.size());
    for (std::size_t k = 0; k < partials.size(); ++k) {
      const features::Feature& mode = set.features[k];
      EXPECT_NEAR(mode.frequency, partials[k].frequency, 0.05);
      EXPECT_NEAR(mode.decay_rate, partials[k].decay_rate, 3 * mode.decay_rate_error);
      EXPECT_LT(mode.decay_rate_error, 0.2 * mode.decay_rate);
    }
    EXPECT_TRUE(set.remarks.empty());
  }
}

TEST(ReverberantModes, TonesThatAreTooSlowToTellAreRemarkedOn) {
  const std::vector<Partial> partials = {{440, 1e-4, 1, 1}, {2330, 5, 1, 3}};
  const ClipShape shape{44100, 1, 0};
  TestRandom random(4);
  std::vector<double> samples = strike_in_room(partials, shape, 0.3, random);
  add_noise(samples, shape, 60, random);
  features::FeatureOptions options{.rt60 = {0.3}};
  const auto set = reverberant_modes(samples, shape.sample_rate, options);
  ASSERT_EQ(set.features.size(), 1u);
  EXPECT_NEAR(set.features[0].frequency, 2330, 1);
  ASSERT_EQ(set.remarks.size(), 1u);
  EXPECT_TRUE(set.remarks[0].starts_with("1 tone decays too slowly")) << set.remarks[0];
  // What is slower than the user's limit is a hum.
  options.min_decay_rate = 1;
  const auto told = reverberant_modes(samples, shape.sample_rate, options);
  EXPECT_TRUE(told.remarks.empty());
  ASSERT_EQ(told.hums.size(), 1u);
  EXPECT_NEAR(told.hums[0].frequency, 440, 1);
  options.min_decay_rate = 10;
  EXPECT_EQ(reverberant_modes(samples, shape.sample_rate, options).nothing, "only steady tones");
}

TEST(ReverberantModes, ReasonsRemarksAndTheEndAreThoseOfAnyExtraction) {
  const features::FeatureOptions in_room{.rt60 = {0.3}};
  for (const std::vector<double>& samples :
       {std::vector<double>{}, std::vector<double>(44100, 0.0), std::vector<double>(20, 0.1)}) {
    const std::string reason = features::extract_features(samples, 44100).nothing;
    EXPECT_FALSE(reason.empty());
    EXPECT_EQ(reverberant_modes(samples, 44100, in_room).nothing, reason);
  }
  // Another strike at 0.8 s ends what is analysed, and so does a duration.
  const std::vector<Partial> partials = {{640, 3, 1, 1}, {2470, 16, 1, 3}};
  const ClipShape shape{44100, 0.8, 0};
  TestRandom random(5);
  std::vector<double> samples(2205, 0.0);
  for (int strike = 0; strike < 2; ++strike) {
    const auto sound = strike_in_room(partials, shape, 0.3, random);
    for (const double sample : sound) samples.push_back(sample * (strike == 0 ? 1 : 0.5));
  }
  add_noise(samples, {44100, 1.65, 0.05}, 50, random);
  const auto set = reverberant_modes(samples, 44100, in_room);
  const auto plain = features::extract_features(samples, 44100);
  ASSERT_FALSE(plain.remarks.empty());
  ASSERT_FALSE(set.remarks.empty());
  EXPECT_EQ(set.remarks[0], plain.remarks[0]);
  EXPECT_EQ(set.onset, plain.onset);
  EXPECT_EQ(set.begin, plain.begin);
  EXPECT_NEAR(set.end, 0.85, 0.01);
  features::FeatureOptions brief = in_room;
  brief.duration = 0.25;
  EXPECT_NEAR(reverberant_modes(samples, 44100, brief).end, set.begin + 0.25, 1e-4);
}

TEST(ReverberantModes, NoiseAloneHasHardlyAny) {
  constexpr std::uint64_t draws = 10;
  std::size_t found = 0;
  for (std::uint64_t seed = 1; seed <= draws; ++seed) {
    TestRandom random(seed);
    std::vector<double> samples;
    for (int n = 0; n < 44100; ++n) {
      samples.push_back(0.1 * std::exp(-23 * n / 44100.0) * random.normal());
    }
    found += modes_in_room(samples, 44100, {.rt60 = {0.3}}).size();
  }
  EXPECT_LE(found, draws / 2);
}

TEST(ReverberantModes, RefuseWhatIsNoSound) {
  const features::FeatureOptions in_room{.rt60 = {0.3}};
  const std::vector<double> silence(100), broken = {0, 1, std::nan("")};
  EXPECT_THROW(reverberant_modes(broken, 44100, in_room), core::InputError);
  EXPECT_THROW(reverberant_modes(silence, 0, in_room), core::InputError);
  EXPECT_THROW(reverberant_modes(silence, 44100, {}), core::InputError);
  EXPECT_THROW(reverberant_modes(silence, 44100, {.rt60 = {0.0, 0.0}}), core::InputError);
  EXPECT_THROW(reverberant_modes(silence, 44100,
                                 {.min_frequency = 30000, .max_frequency = 40000, .rt60 = {0.3}}),
               core::InputError);
}

TEST(DampingData, ReverberantModesKeepTheirProportionsWhenJoined) {
  features::Feature slow, fast;
  slow.frequency = 500, slow.decay_rate = 5, slow.decay_rate_error = 0.1;
  fast.frequency = 5000, fast.decay_rate = 60, fast.decay_rate_error = 12;
  const DampingData room = reverberant_data(std::vector{slow, fast});
  ASSERT_EQ(room.size(), 2u);
  EXPECT_TRUE(room.ceilings.empty());
  EXPECT_NEAR(room.proportions[0], 0.02, 1e-15);
  EXPECT_NEAR(room.proportions[1], 0.2, 1e-15);
  const DampingData all = joined(std::vector{damping_data(std::vector{slow}), room});
  ASSERT_EQ(all.proportions.size(), 3u);
  EXPECT_EQ(all.proportions[0], 0);
  EXPECT_NEAR(all.proportions[2], 0.2, 1e-15);
}

}  // namespace
}  // namespace carillon::eval::damping
