// Supports where they are hardest: forces from nothing to everything, critical and coinciding
// poles, contact everywhere; and on a real body, a ceramic plate held by two fingers.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "../solvers/test_meshes.hpp"
#include "core/error.hpp"
#include "hard_case.hpp"
#include "synth/support/coupled_modes.hpp"
#include "synth/support/diagonal_error.hpp"
#include "synth/support/supports.hpp"
#include "synth/surface/rigid_body.hpp"
#include "tests/synth/support_cases.hpp"

namespace carillon {
namespace {

using namespace test;
using namespace synth;

constexpr double pi = std::numbers::pi;

/// Struck and heard so that every mode counts.
synth::modal::RingDown struck(const HeldModes& held) {
  const auto n = static_cast<Eigen::Index>(held.eigenvalues.size());
  synth::modal::RingDown rings;
  rings.eigenvalues = held.eigenvalues;
  rings.decay_rates = held.decay_rates;
  rings.excitation = Eigen::VectorXd::LinSpaced(n, 1, 1.5);
  rings.readout.velocity = Eigen::RowVectorXd::LinSpaced(n, 1, -0.7);
  rings.readout.delays = {0.0};
  return rings;
}

synth::modal::RingDown diagonal_answer(const HeldModes& held) {
  synth::modal::RingDown rings = struck(held);
  rings.decay_rates = diagonal_rates(held.decay_rates, held.dashpots);
  return rings;
}

std::optional<synth::modal::RingDown> coupled_answer(const HeldModes& held,
                                                     double* perturbation = nullptr) {
  const auto modes = synth::support::couple(held.eigenvalues, held.decay_rates, held.dashpots);
  if (!modes) return std::nullopt;
  if (perturbation != nullptr) *perturbation = modes->perturbation;
  return synth::support::coupled_ring_down(*modes, struck(held));
}

double peak(const std::vector<float>& samples) {
  double largest = 0;
  for (const float s : samples) largest = std::max(largest, std::abs(static_cast<double>(s)));
  return largest;
}

bool finite(const std::vector<float>& samples) {
  return std::all_of(samples.begin(), samples.end(), [](float s) { return std::isfinite(s); });
}

/// Largest distance from matrix exponentials, relative to the peak.
double off_from_exact(const HeldModes& held, const synth::modal::RingDown& answer) {
  const std::vector<double> times = {1e-4, 2e-4, 5e-4, 1e-3, 3e-3, 0.01, 0.05};
  const synth::modal::RingDown rings = struck(held);
  const auto states = exact_states(held, rings.excitation, 2e-4, times);
  const auto n = static_cast<Eigen::Index>(held.eigenvalues.size());
  double worst = 0, loudest = 0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double exact = (rings.readout.velocity * states[k].tail(n))[0];
    worst = std::max(worst, std::abs(value_at(answer, 2e-4, times[k])[0] - exact));
    loudest = std::max(loudest, std::abs(exact));
  }
  return worst / loudest;
}

HeldModes one_mode(double hertz, double own, double dashpot) {
  HeldModes held;
  held.eigenvalues = {std::pow(2 * pi * hertz, 2)};
  held.decay_rates = {own};
  held.dashpots = Eigen::MatrixXd::Constant(1, 1, std::sqrt(dashpot));
  return held;
}

TEST(SupportsHard, AtAndBeyondCriticalThroughTheSupport) {
  const double omega = 2 * pi * 440;
  for (const double ratio : {0.999, 1 - 1e-9, 1.0, 1 + 1e-9, 1.001, 10.0, 1e6}) {
    const HeldModes held = one_mode(440, 0, 2 * ratio * omega);
    double perturbation = 0;
    const auto full = coupled_answer(held, &perturbation);
    ASSERT_TRUE(full) << ratio;
    EXPECT_LE(perturbation, 1e-6) << ratio;
    // One mode has nothing to couple with: the diagonal answer is exact.
    const auto alone = synth::modal::synthesize(diagonal_answer(held), {2e-4}, 44100, 4000);
    const auto audio = synth::modal::synthesize(*full, {2e-4}, 44100, 4000);
    ASSERT_TRUE(finite(audio) && finite(alone)) << ratio;
    double worst = 0;
    for (std::size_t n = 0; n < audio.size(); ++n) {
      worst = std::max(worst, std::abs(static_cast<double>(audio[n]) - alone[n]));
    }
    EXPECT_LT(worst, 2e-6 * peak(alone)) << ratio;
  }
}

TEST(SupportsHard, TwoModesABillionthApart) {
  HeldModes held = random_held(6, 2, 20, 3);
  held.eigenvalues[3] = held.eigenvalues[2] * std::pow(1 + 1e-9, 2);
  const auto full = coupled_answer(held);
  ASSERT_TRUE(full);
  EXPECT_LT(off_from_exact(held, *full), 1e-9);
  // A single dashpot moves one combination of them and leaves the other ringing: the diagonal
  // answer, which damps both, is wrong there however light the touch.
  HeldModes pair = one_mode(1000, 1, 4);
  pair.eigenvalues.push_back(pair.eigenvalues[0] * std::pow(1 + 1e-9, 2));
  pair.decay_rates.push_back(1);
  pair.dashpots = Eigen::Vector2d(2, 2);
  const auto split = synth::support::couple(pair.eigenvalues, pair.decay_rates, pair.dashpots);
  ASSERT_TRUE(split);
  const auto [slow, fast] = std::minmax(split->decay_rates[0], split->decay_rates[1]);
  EXPECT_NEAR(slow, 1, 1e-6);
  EXPECT_NEAR(fast, 1 + 4, 1e-6);
}

TEST(SupportsHard, TwoModesAtTheirExceptionalPoint) {
  // Apart by as much as the dashpot couples them, their two poles and eigenvectors are one.
  const double omega = 2 * pi * 1000;
  for (const double off : {0.0, 1e-12, 1e-9, 1e-6, 1e-3}) {
    // Near omega, equal dashpots g put the poles at -g/2 +- sqrt(g^2 - apart^2) / 2.
    const double apart = 40 * (1 + off);
    HeldModes held = one_mode(1000, 0, 0);
    held.eigenvalues = {std::pow(omega - apart / 2, 2), std::pow(omega + apart / 2, 2)};
    held.decay_rates = {0, 0};
    held.dashpots = Eigen::Vector2d::Constant(std::sqrt(40.0));
    const auto full = coupled_answer(held);
    ASSERT_TRUE(full) << off;
    EXPECT_LT(off_from_exact(held, *full), 1e-5) << off;
  }
}

TEST(SupportsHard, TripleCriticalPoles) {
  // A double real pole in each of two modes that one dashpot joins.
  HeldModes held = one_mode(300, 2 * pi * 300, 1e-3);
  held.eigenvalues.push_back(held.eigenvalues[0]);
  held.decay_rates.push_back(held.decay_rates[0]);
  held.dashpots = Eigen::Vector2d::Constant(0.03);
  const auto full = coupled_answer(held);
  if (full) {
    EXPECT_LT(off_from_exact(held, *full), 1e-4);
  }
  EXPECT_TRUE(
      finite(synth::modal::synthesize(full ? *full : diagonal_answer(held), {2e-4}, 44100, 1000)));
}

TEST(SupportsHard, ForcesFromNothingToEverything) {
  // Fingers of unit coefficient at dashpots of phi^2 = 9 / kg.
  HeldModes held = random_held(20, 2, 9, 7);
  const Eigen::MatrixXd unit = held.dashpots;
  held.dashpots = synth::support::dashpots(unit, 1, 1e-12);
  const auto nothing = coupled_answer(held);
  ASSERT_TRUE(nothing);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_NEAR(nothing->decay_rates[i] / held.decay_rates[i], 1, 1e-10);
    EXPECT_NEAR(diagonal_answer(held).decay_rates[i] / held.decay_rates[i], 1, 1e-10);
  }
  // Pressed without end the points stand still: all but two modes ring on, and no more force
  // changes them.
  held.dashpots = synth::support::dashpots(unit, 1, 1e9);
  const auto firm = coupled_answer(held);
  held.dashpots = synth::support::dashpots(unit, 1, 1e12);
  const auto rigid = coupled_answer(held);
  ASSERT_TRUE(firm && rigid);
  const auto ringing = [](const synth::modal::RingDown& rings) {
    std::vector<std::pair<double, double>> modes;
    for (std::size_t i = 0; i < rings.eigenvalues.size(); ++i) {
      const double d = rings.decay_rates[i];
      if (rings.eigenvalues[i] > d * d) modes.emplace_back(rings.eigenvalues[i], d);
    }
    std::sort(modes.begin(), modes.end());
    return modes;
  };
  const auto a = ringing(*firm), b = ringing(*rigid);
  ASSERT_EQ(a.size(), 18u);
  ASSERT_EQ(b.size(), 18u);
  for (std::size_t i = 0; i < 18; ++i) {
    EXPECT_NEAR(b[i].first / a[i].first, 1, 1e-6);
    EXPECT_NEAR(b[i].second / a[i].second, 1, 1e-4);
  }
  const auto audio = synth::modal::synthesize(*rigid, {2e-4}, 44100, 4000);
  EXPECT_TRUE(finite(audio));
  EXPECT_LT(peak(audio), 100);
  EXPECT_TRUE(finite(synth::modal::synthesize(diagonal_answer(held), {2e-4}, 44100, 4000)));
}

solvers::modes::Modes ceramic_plate() {
  const solvers::elements::Elastic ceramic{7.2e10, 0.19, 2700};
  return modes_in(box_mesh({0.1, 0.12, 0.006}, {7, 8, 1}, 3), {ceramic}, {20, 20000, 300});
}

TEST(SupportsHard, AContactOnANodeLineAddsNothing) {
  // The first bending shape of a slim bar stands still on two lines, 0.224 of its length from
  // either end.
  const solvers::elements::Elastic glass_bar{6.2e10, 0.2, 2600};
  const auto modes =
      modes_in(box_mesh({0.2, 0.01, 0.005}, {16, 1, 1}, 3), {glass_bar}, {20, 5000, 20});
  const synth::modal::SurfaceSampler sampler(modes.surface);
  const auto added = [&](double x) {
    const auto contact =
        synth::support::point_contact(modes.surface, sampler.nearest({x * 0.2, 0.005, 0.005}));
    const Eigen::MatrixXd held =
        synth::support::dashpots(synth::support::contact_factor(modes, contact, 0), 1, 1);
    return diagonal_rates(std::vector<double>(modes.size(), 0.0), held)[0];
  };
  EXPECT_LT(added(0.2242), 1e-4 * added(0.5));
  EXPECT_GT(added(0.5), 1);
}

TEST(SupportsHard, ContactOnEveryNode) {
  const auto modes = ceramic_plate();
  std::vector<synth::support::Contact> contacts;
  const auto faces = modes.surface.faces.size() / 10;  // ten nodes to a cubic face
  for (std::size_t face = 0; face < faces; ++face) {
    const synth::modal::SurfacePoint point{static_cast<std::int32_t>(face), {1, 0, 0}};
    contacts.push_back({point, synth::modal::frame_at(modes.surface, point).normal,
                        1.0 / static_cast<double>(faces)});
  }
  HeldModes held;
  held.eigenvalues = modes.eigenvalues;
  held.decay_rates.assign(modes.size(), 2.0);
  held.dashpots =
      synth::support::dashpots(synth::support::contact_factor(modes, contacts, 0.5), 1, 5);
  EXPECT_LE(held.dashpots.cols(), static_cast<Eigen::Index>(modes.size()));
  const auto full = synth::support::couple(held.eigenvalues, held.decay_rates, held.dashpots);
  ASSERT_TRUE(full);
  EXPECT_LT(worst_pole(poles_of(full->eigenvalues, full->decay_rates),
                       eigenvalues_of(held.state_matrix())),
            1e-9);
  for (const double d : full->decay_rates) EXPECT_GT(d, 2);
}

// The figures of docs/sound/supports.md.
TEST(SupportsHard, CeramicPlateHeldByTwoFingers) {
  const auto modes = ceramic_plate();
  ASSERT_GT(modes.size(), 20u);
  std::vector<double> own;
  for (const double lambda : modes.eigenvalues) own.push_back((6 + 1e-7 * lambda) / 2);
  const synth::modal::SurfaceSampler sampler(modes.surface);
  // Pinched at the middle of an edge, 5 mm from it, from both sides.
  std::vector<synth::support::Contact> contacts;
  for (const double z : {0.0, 0.006}) {
    for (const synth::support::Contact& contact :
         synth::support::patch_contacts(modes.surface, synth::surface::outer_pieces(modes.surface),
                                        sampler.nearest({0.005, 0.06, z}), 0.004)) {
      contacts.push_back(contact);
    }
  }
  const synth::support::SupportKind finger = synth::support::parse_support("finger");
  const synth::surface::RigidBody rigid = synth::surface::rigid_body(modes);
  const Eigen::MatrixXd unit =
      synth::support::contact_factor(modes, contacts, finger.friction, &rigid);
  const auto n = static_cast<Eigen::Index>(modes.size());
  double last = 0;
  for (const double force : {0.1, 0.3, 1.0, 3.0, 10.0, 30.0}) {
    const Eigen::MatrixXd held = synth::support::dashpots(unit, finger.coefficient, force);
    const auto full = synth::support::couple(modes.eigenvalues, own, held);
    ASSERT_TRUE(full);
    const auto diagonal = diagonal_rates(own, held.topRows(n));
    // The whole state: modes, and the velocities of the body as a whole.
    const HeldModes held_modes{modes.eigenvalues, own, held.topRows(n)};
    Eigen::MatrixXd state = Eigen::MatrixXd::Zero(2 * n + 6, 2 * n + 6);
    state.topLeftCorner(2 * n, 2 * n) = held_modes.state_matrix();
    state.block(n, 2 * n, n, 6) = -held.topRows(n) * held.bottomRows(6).transpose();
    state.block(2 * n, n, 6, n) = -held.bottomRows(6) * held.topRows(n).transpose();
    state.bottomRightCorner(6, 6) = -held.bottomRows(6) * held.bottomRows(6).transpose();
    EXPECT_LT(worst_pole(poles_of(full->eigenvalues, full->decay_rates), eigenvalues_of(state)),
              1e-8);
    const synth::support::DiagonalError error =
        synth::support::diagonal_error(*full, modes.eigenvalues, diagonal);
    std::printf("%5.1f N: T60 of the first mode %.3f s free, %.4f s diagonal, %.4f s full; %s\n",
                force, synth::modal::t60(own[0]), synth::modal::t60(diagonal[0]),
                synth::modal::t60(full->decay_rates[0]), describe(error).c_str());
    EXPECT_LT(synth::modal::t60(diagonal[0]), synth::modal::t60(own[0]));
    EXPECT_GT(error.decay_rate, last);
    last = error.decay_rate;
  }
}

/// Best of a few runs; printed, not judged.
template <class Work>
double seconds_of(const Work& work) {
  double best = 1e9;
  for (int run = 0; run < 3; ++run) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

TEST(SupportsHard, TwoThousandModes) {
  const HeldModes held = random_held(2000, 6, 30, 1);
  EXPECT_THROW(synth::support::couple(held.eigenvalues, held.decay_rates, held.dashpots),
               core::InputError);
  const auto diagonal = diagonal_rates(held.decay_rates, held.dashpots);
  synth::support::DiagonalError error;
  const double seconds = seconds_of([&] {
    error = synth::support::estimate_diagonal_error(held.eigenvalues, diagonal, held.dashpots);
  });
  std::printf("2000 modes: estimate %.3g ms; %s\n", 1e3 * seconds, describe(error).c_str());
  EXPECT_TRUE(std::isfinite(error.decay_rate) && std::isfinite(error.cents));
}

TEST(SupportsHard, ThreeHundredModes) {
  for (const int n : {60, 300}) {
    const HeldModes held = random_held(n, 6, 30, 1);
    const synth::modal::RingDown rings = struck(held);
    std::optional<synth::support::CoupledModes> modes;
    synth::modal::RingDown answer;
    const double diagonal = seconds_of([&] { diagonal_rates(held.decay_rates, held.dashpots); });
    const double solve = seconds_of(
        [&] { modes = synth::support::couple(held.eigenvalues, held.decay_rates, held.dashpots); });
    ASSERT_TRUE(modes);
    const double turn =
        seconds_of([&] { answer = synth::support::coupled_ring_down(*modes, rings); });
    std::printf("%d modes: diagonal %.2g ms, coupled %.3g ms, then %.2g ms for each strike\n", n,
                1e3 * diagonal, 1e3 * solve, 1e3 * turn);
    EXPECT_LT(worst_pole(poles_of(modes->eigenvalues, modes->decay_rates),
                         eigenvalues_of(held.state_matrix())),
              1e-8);
    EXPECT_TRUE(finite(synth::modal::synthesize(answer, {2e-4}, 44100, 4410)));
  }
}

}  // namespace
}  // namespace carillon
