#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "eval/recorded_objects/impact_contact.hpp"
#include "eval/recorded_objects/impact_folder.hpp"

namespace carillon::eval::recorded_objects {
namespace {

constexpr double rate = 48000;

/// A force of some shape from `begin` on, both in seconds.
template <class Shape>
std::vector<double> force(double begin, double duration, Shape shape) {
  std::vector<double> samples(4800, 0.0);
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const double phase = (static_cast<double>(n) / rate - begin) / duration;
    if (phase >= 0 && phase <= 1) samples[n] = shape(phase);
  }
  return samples;
}

double raised_cosine(double phase) {
  return 1 - std::cos(2 * std::numbers::pi * phase);
}
double half_sine(double phase) {
  return std::sin(std::numbers::pi * phase);
}

TEST(ImpactContact, IsThatOfARaisedCosine) {
  for (const double duration : {3e-4, 1e-3, 5e-3}) {
    const ImpactContact contact = contact_of(force(0.02, duration, raised_cosine), rate);
    EXPECT_NEAR(contact.begin, 0.02, 0.5 / rate);
    EXPECT_NEAR(contact.duration / duration, 1, 0.04) << duration;
  }
}

TEST(ImpactContact, HasTheSpectrumOfAnotherShape) {
  // Of a half sine of duration t: cos(w t / 2) / (1 - (w t / pi)^2), over its value at 0; of a
  // raised cosine of T: sin(x) / (x (1 - (x / pi)^2)), x = w T / 2. They fall by 2 dB alike.
  const double duration = 2e-3;
  const ImpactContact contact = contact_of(force(0.01, duration, half_sine), rate);
  const double w = 2 * std::numbers::pi * 240;
  const double sine =
      std::cos(0.5 * w * duration) / (1 - std::pow(w * duration / std::numbers::pi, 2));
  const double x = 0.5 * w * contact.duration;
  const double cosine = std::sin(x) / (x * (1 - std::pow(x / std::numbers::pi, 2)));
  EXPECT_LT(sine, 0.81);
  EXPECT_NEAR(20 * std::log10(cosine / sine), 0, 0.1);
}

TEST(ImpactContact, IsOneSampleOfAnImpulseAndRefusesSilence) {
  std::vector<double> samples(100, 0.0);
  EXPECT_THROW(contact_of(samples, rate), core::InputError);
  EXPECT_THROW(contact_of({}, rate), core::InputError);
  samples[40] = -3;
  samples[50] = 2;
  const ImpactContact contact = contact_of(samples, rate);
  EXPECT_DOUBLE_EQ(contact.begin, 50 / rate);
  EXPECT_EQ(contact.duration, 0);
}

TEST(MaterialInName, IsAWordOfIt) {
  EXPECT_EQ(material_in_name("17_IronSkillet"), "iron");
  EXPECT_EQ(material_in_name("9_BowlCeramic"), "ceramic");
  EXPECT_EQ(material_in_name("wood-plate 3"), "wood");
  EXPECT_EQ(material_in_name("91_MetalSpoon"), "steel");
  EXPECT_EQ(material_in_name("PLASTIC"), "plastic");
}

TEST(MaterialInName, IsNoneWhereNoneOrSeveralAreNamed) {
  for (const char* name :
       {"", "22_Cup", "93_GreenGoblet", "woodpecker", "31_PetBowl", "GlassOnWood", "59_stand"}) {
    EXPECT_EQ(material_in_name(name), "") << name;
  }
}

}  // namespace
}  // namespace carillon::eval::recorded_objects
