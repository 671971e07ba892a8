#include "eval/perception/spectral_distance.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::eval {
namespace {

std::vector<double> ringing(double amplitude, double decay_rate, double frequency, double phase,
                            std::size_t count = 5000) {
  std::vector<double> samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / 24000;
    samples[i] = amplitude * std::exp(-decay_rate * t) *
                 std::cos(2 * std::numbers::pi * frequency * t + phase);
  }
  return samples;
}

TEST(SpectralDistance, IsNumPys) {
  // def magnitudes(x, n, h, w):
  //     window = numpy.zeros(n); a = (n - w) // 2
  //     window[a:a + w] = 0.5 - 0.5 * numpy.cos(2 * numpy.pi * numpy.arange(w) / w)
  //     p = numpy.pad(x, n // 2, mode='reflect')
  //     frames = numpy.array([p[i * h:i * h + n] * window for i in range(1 + len(x) // h)])
  //     return numpy.sqrt(numpy.maximum(numpy.abs(numpy.fft.rfft(frames, axis=1))**2, 1e-7))
  // numpy.linalg.norm(X - Y) / numpy.linalg.norm(X), numpy.mean(abs(numpy.log(X) - numpy.log(Y)))
  const auto x = ringing(1, 20, 900, 0), y = ringing(0.7, 30, 910, 1);
  const perception::SpectralDistance forth = perception::spectral_distance(x, y),
                                     back = perception::spectral_distance(y, x);
  EXPECT_NEAR(forth.convergence, 0.5875001519076776, 1e-10);
  EXPECT_NEAR(forth.log_magnitude, 0.5335819136235707, 1e-10);
  EXPECT_NEAR(back.convergence, 1.0131191055228468, 1e-10);
  EXPECT_EQ(back.log_magnitude, forth.log_magnitude);
  EXPECT_EQ(forth.total(), forth.convergence + forth.log_magnitude);
}

TEST(SpectralDistance, OfASoundAgainstItselfIsNothing) {
  for (const std::size_t count : {1U, 2U, 100U, 3000U}) {
    const auto x = ringing(0.5, 9, 440, 0.3, count);
    EXPECT_EQ(perception::spectral_distance(x, x).total(), 0) << count;
  }
}

TEST(SpectralDistance, OfAGainIsTheGain) {
  EXPECT_TRUE(rc::check("|1 - g| and |ln g|", [] {
    core::RandomStream random(*rc::gen::inRange(0, 1000), 0, "test.spectra");
    // Noise far above the floor.
    std::vector<double> x(3000);
    for (double& sample : x) sample = 1e3 * random.normal();
    const double gain = std::pow(10, *rc::gen::inRange(-40, 41) / 20.0);
    std::vector<double> y = x;
    for (double& sample : y) sample *= gain;
    const perception::SpectralDistance distance = perception::spectral_distance(x, y);
    RC_ASSERT(std::abs(distance.convergence - std::abs(1 - gain)) < 1e-9 * (1 + gain));
    RC_ASSERT(std::abs(distance.log_magnitude - std::abs(std::log(gain))) < 1e-4);
  }));
}

TEST(SpectralDistance, OfSilenceIsFinite) {
  const std::vector<double> silence(4000, 0.0);
  EXPECT_EQ(perception::spectral_distance(silence, silence).total(), 0);
  const auto x = ringing(1, 20, 900, 0, 4000);
  // All of the reference is missing, but for the floor.
  EXPECT_NEAR(perception::spectral_distance(x, silence).convergence, 1, 1e-3);
  EXPECT_TRUE(std::isfinite(perception::spectral_distance(silence, x).total()));
  EXPECT_THROW(perception::spectral_distance({}, {}), core::InputError);
  EXPECT_THROW(perception::spectral_distance(x, std::vector<double>(3999, 0.0)), core::InputError);
}

}  // namespace
}  // namespace carillon::eval
