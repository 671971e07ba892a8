// A mode under a force of straight pieces: against the raised cosine's closed form and against
// superposed ramps.
#include "synth/sampled_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/error.hpp"

namespace carillon::synth {
namespace {

TEST(SampledResponse, ComesToTheClosedFormOfAFinelySampledPulse) {
  const double T = 1e-3;
  for (const double d : {0.0, 50.0, 4000.0, 60000.0}) {
    const double lambda = 1e8;
    const ModalResponse exact(lambda, d, T);
    double last = 0;
    for (const int pieces : {100, 200}) {
      std::vector<double> force;
      for (int k = 0; k <= pieces; ++k) force.push_back(contact_force(T, T * k / pieces));
      const SampledResponse response(lambda, d, force, T);
      double worst = 0, size = 0;
      for (int n = 1; n < 400; ++n) {
        const double t = 2.0 * T * n / 400;
        const Motion a = t <= T ? exact.during_contact(t) : exact.after_contact(t - T);
        const Motion b = response.at(t);
        worst = std::max(worst, std::abs(a.velocity - b.velocity));
        size = std::max(size, std::abs(a.velocity));
      }
      if (pieces == 200) {
        EXPECT_NEAR(last / worst, 4, 0.2) << d;  // of second order
      }
      EXPECT_LT(worst / size, 2e-3) << d;
      last = worst;
    }
    EXPECT_NEAR(SampledResponse(lambda, d, std::vector<double>{0, 2 / T, 0}, T).impulse(T), 1,
                1e-12);
  }
}

TEST(SampledResponse, OfOneRampIsTheTextbooks) {
  // q'' + lambda q = t: q = (t - sin(w t) / w) / lambda, on a grid that does not fall on samples.
  const double w = 300, T = 0.1;
  std::vector<double> force;
  for (int k = 0; k <= 7; ++k) force.push_back(T * k / 7);
  const SampledResponse response(w * w, 0, force, T);
  for (const double t : {0.001, 0.0437, 0.0999}) {
    EXPECT_NEAR(response.at(t).displacement / ((t - std::sin(w * t) / w) / (w * w)), 1, 1e-9) << t;
    EXPECT_NEAR(response.at(t).acceleration, std::sin(w * t) / w, 1e-9 / w);
    EXPECT_NEAR(response.impulse(t), t * t / 2, 1e-15);
  }
}

TEST(SampledResponse, RefusesForcesWithoutExtent) {
  EXPECT_THROW(SampledResponse(1, 0, std::vector<double>{1}, 1), core::InputError);
  EXPECT_THROW(SampledResponse(1, 0, std::vector<double>{1, 2}, 0), core::InputError);
  EXPECT_THROW(SampledResponse(1, 0, std::vector<double>{1, std::nan("")}, 1), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
