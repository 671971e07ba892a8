#include "eval/material/detail/minimise.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "eval/material/detail/coordinates.hpp"

namespace carillon::eval {
namespace {

TEST(Minimise, FindsTheEndOfABentValley) {
  const auto rosenbrock = [](std::span<const double> x) {
    return 100 * std::pow(x[1] - x[0] * x[0], 2) + std::pow(1 - x[0], 2);
  };
  const std::vector steps = {0.1, 0.1};
  const material::Minimum found = material::minimise(rosenbrock, {-1.2, 1}, steps, 1e-14, 5000);
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.x[0], 1, 1e-3);
  EXPECT_NEAR(found.x[1], 1, 1e-3);
  const material::Minimum cut = material::minimise(rosenbrock, {-1.2, 1}, steps, 1e-14, 10);
  EXPECT_FALSE(cut.converged);
  EXPECT_LE(cut.evaluations, 11);
}

TEST(Minimise, LetsErrorsThrough) {
  const auto fails = [](std::span<const double>) -> double { throw core::InputError("no"); };
  EXPECT_THROW(material::minimise(fails, {0.0}, std::vector{1.0}, 1e-6, 100), core::InputError);
}

TEST(Coordinates, LeadBackToTheCandidate) {
  const std::vector<std::pair<damping::DampingLaw, std::vector<double>>> laws = {
      {{synth::damping::DampingKind::rayleigh, 2, ""}, {5, 3e-8}},
      {{synth::damping::DampingKind::power, 2, ""}, {0.2, 0.4}},
      {{synth::damping::DampingKind::hybrid, 3, ""}, {4, 5e-9, 1.03}},
      {{synth::damping::DampingKind::caughey, 3, ""}, {280, -3.6e-7, 2e-15}},
      {{synth::damping::DampingKind::expression, 2, "alpha1 + alpha2*f"}, {0, -2}},
  };
  for (const auto& [law, alphas] : laws) {
    material::Candidate candidate;
    candidate.specific_modulus = 2e7;
    candidate.scale = 3e-4;
    candidate.contact_time = 1e-4;
    candidate.damping = {law.kind, alphas, law.expression};
    for (const bool sought : {false, true}) {
      material::Coordinates coordinates =
          material::make_coordinates(law, candidate.damping, 1e8, 20);
      coordinates.contact_sought = sought;
      coordinates.contact_time = 1e-4;
      const auto x = material::to_coordinates(coordinates, candidate);
      ASSERT_EQ(x.size(), alphas.size() + (sought ? 3 : 2));
      ASSERT_EQ(material::first_steps(coordinates).size(), x.size());
      const material::Candidate back = material::from_coordinates(coordinates, x);
      EXPECT_NEAR(back.specific_modulus, 2e7, 1);
      EXPECT_NEAR(back.scale, 3e-4, 1e-12);
      EXPECT_NEAR(back.contact_time, 1e-4, 1e-12);
      for (std::size_t k = 0; k < alphas.size(); ++k) {
        EXPECT_NEAR(back.damping.parameters[k], alphas[k], 1e-9 * std::abs(alphas[k]));
      }
    }
  }
}

}  // namespace
}  // namespace carillon::eval
