#include "synth/motion/lasting_force.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

#include "core/error.hpp"
#include "tests/synth/scraped_face.hpp"

namespace carillon::synth {
namespace {

constexpr double audio_rate = 44100;

/// No tracing, no roughness, no patch: the map alone.
motion::LastingForceOptions bare() {
  motion::LastingForceOptions options;
  options.edge_radius = 0;
  options.roughness = 0;
  return options;
}

/// Amplitude and phase of a frequency in a stretch, under a Hann window.
std::complex<double> line(const Eigen::VectorXd& samples, double frequency) {
  std::complex<double> sum;
  const double n = static_cast<double>(samples.size());
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    const double window = 1 - std::cos(2 * M_PI * (static_cast<double>(i) + 0.5) / n);
    sum += window * samples[i] *
           std::polar(1.0, -2 * M_PI * frequency * static_cast<double>(i) / audio_rate);
  }
  return 2.0 / n * sum;
}

/// Frequency near a guess where the stretch's line is strongest, by golden section.
double pitch(const Eigen::VectorXd& samples, double guess) {
  double low = guess * 0.99, high = guess * 1.01;
  for (int i = 0; i < 40; ++i) {
    const double a = high - 0.618 * (high - low), b = low + 0.618 * (high - low);
    if (std::abs(line(samples, a)) > std::abs(line(samples, b))) {
      high = b;
    } else {
      low = a;
    }
  }
  return (low + high) / 2;
}

Eigen::VectorXd normal_force(const Scrape& scrape, const motion::LastingForceOptions& options) {
  motion::LastingForces forces(scrape.motion, scrape.bodies, options);
  const motion::LastingForce force = forces.force(0);
  // Without the fades.
  return force.force.row(2).segment(400, force.force.cols() - 800).transpose();
}

TEST(LastingForce, ASineSoundsAtSpeedOverWavelengthAndWithTheSquareOfTheSpeed) {
  constexpr double full_length = 2e-3, groove_depth = 1e-6;
  const render::maps::SurfaceMap map = sine_map(full_length, groove_depth, 32, 16);
  // A B-spline is sinc^4 as deep as its control points.
  const double sinc = std::sin(M_PI / 32) / (M_PI / 32);
  double before = 0;
  for (const double speed : {0.25, 0.5, 1.0}) {
    const Scrape scrape(map, speed, 5, 1);
    const Eigen::VectorXd force = normal_force(scrape, bare());
    const double expected = speed / full_length;
    EXPECT_NEAR(pitch(force, expected), expected, 1e-4 * expected);
    const double amplitude = std::abs(line(force, expected));
    const double omega = 2 * M_PI * expected;
    EXPECT_NEAR(amplitude, 0.1 * omega * omega * groove_depth * std::pow(sinc, 4),
                2e-3 * amplitude);
    // Power goes with the fourth power of the speed.
    if (before > 0) {
      EXPECT_NEAR(amplitude / before, 4, 4e-3);
    }
    before = amplitude;
    EXPECT_LT(std::abs(line(force, 2 * expected)), 1e-3 * amplitude);
  }
}

TEST(LastingForce, OfAFlatFaceIsNothingAtAll) {
  render::maps::SurfaceMap map = sine_map(2e-3, 0, 16, 4);
  for (float& height : map.heights) height = -3e-4F;
  for (const bool textured : {true, false}) {
    Scrape scrape(map, 0.3, 5, 0.2);
    if (!textured) scrape.bodies[1].texture.reset();
    // A solver's chatter.
    std::mt19937 random(1);
    std::uniform_real_distribution<double> chatter(0, 2);
    for (motion::ContactStep& step : scrape.motion.contacts[0].steps) step.force *= chatter(random);
    motion::LastingForceOptions options = bare();
    options.edge_radius = 1e-3;
    motion::LastingForces forces(scrape.motion, scrape.bodies, options);
    EXPECT_TRUE(forces.force(0).force.isZero(0));
    options.roughness = 0.1;
    motion::LastingForces rough(scrape.motion, scrape.bodies, options);
    EXPECT_GT(rough.force(0).force.cwiseAbs().maxCoeff(), 0.01);
  }
}

TEST(LastingForce, IsNothingWhileTheBodiesPart) {
  const Scrape scrape(sine_map(2e-3, 1e-5, 32, 16), 1.0, 2, 0.3);
  const Eigen::VectorXd force = normal_force(scrape, bare());
  // m z'' reaches 10 N, F is 2 N.
  EXPECT_NEAR(force.minCoeff(), -2, 1e-9);
  EXPECT_GT(force.maxCoeff(), 8);
  EXPECT_GT((force.array() < -1.999999).count(), force.size() / 4);
}

/// A ramp down along u, of a slope, from u = 0 on.
render::maps::SurfaceMap ramp_map(double slope) {
  render::maps::SurfaceMap map;
  map.width = 500;
  map.height = 4;
  map.texel = 1e-3;
  map.repeats = false;
  for (int j = 0; j < map.height; ++j) {
    for (int i = 0; i < map.width; ++i) {
      map.heights.push_back(static_cast<float>(-slope * (i + 0.5) * map.texel));
    }
  }
  return map;
}

// Down a slope at an even speed the face pushes along its normal, ahead by slope times force; a
// speed that grows adds mass times slope times its growth.
TEST(LastingForce, OnASlopeItLeansAndGrowsWithTheAcceleration) {
  constexpr double ramp_slope = 0.04, pressing_force = 5, mass = 0.1, gain = 3;
  Scrape even(ramp_map(ramp_slope), 0.2, pressing_force, 0.3);
  motion::LastingForces forces(even.motion, even.bodies, bare());
  Eigen::Matrix3Xd force = forces.force(0).force;
  EXPECT_NEAR(force(0, 6000), ramp_slope * pressing_force, 1e-4);
  EXPECT_NEAR(force(2, 6000), 0, 1e-4);
  for (std::size_t k = 0; k < even.motion.contacts[0].steps.size(); ++k) {
    const double time = 1e-3 * static_cast<double>(k);
    motion::ContactStep& step = even.motion.contacts[0].steps[k];
    step.points[1].x() = 0.01 + 0.2 * time + gain * time * time / 2;
    step.slip.x() = 0.2 + gain * time;
  }
  motion::LastingForces faster(even.motion, even.bodies, bare());
  force = faster.force(0).force;
  const double more = -mass * ramp_slope * gain;
  EXPECT_NEAR(force(2, 6000), more, 2e-2 * std::abs(more));
}

// A tile whose contact hops from wave to wave as it slides does not sweep the waves between at the
// speed of the hops.
TEST(LastingForce, HopsOfACornerAreNoSweeps) {
  constexpr double sliding_speed = 0.1;
  const render::maps::SurfaceMap map = sine_map(2e-3, 1e-6, 32, 16);
  const Scrape even(map, sliding_speed, 5, 0.3);
  Scrape hopping = even;
  for (motion::MovingBody& body : hopping.bodies) body.hulls = {{Vec3(0.05, 0.05, 0.05)}};
  for (std::size_t k = 0; k < hopping.motion.contacts[0].steps.size(); ++k) {
    const double way = sliding_speed * 1e-3 * static_cast<double>(k);
    hopping.motion.contacts[0].steps[k].points[1].x() = 0.01 + 2e-3 * std::floor(way / 2e-3);
  }
  const double maximum = normal_force(hopping, bare()).cwiseAbs().maxCoeff();
  // 1.25 times the speed, with the square; and starts and stops of some steps.
  EXPECT_LT(maximum, 3 * normal_force(even, bare()).cwiseAbs().maxCoeff());
  EXPECT_GT(maximum, 0);
}

// Contacts of the same two bodies share their mass as they share their force.
TEST(LastingForce, ContactsOfAPairShareItsMass) {
  Scrape one(sine_map(2e-3, 1e-6, 32, 16), 0.5, 5, 0.2);
  const Eigen::VectorXd alone = normal_force(one, bare());
  Scrape two = one;
  two.motion.contacts.push_back(two.motion.contacts[0]);
  for (motion::ContactStep& step : two.motion.contacts[1].steps) step.force *= 3;
  EXPECT_LT((4 * normal_force(two, bare()) - alone).norm(), 1e-9 * alone.norm());
}

// Momentum in steps from texel to texel against the heights' second derivative: what they add up
// to within waves, which is what is left of steps far above them.
TEST(LastingForce, ThePapersMomentumStepsTendToTheHeightProfile) {
  constexpr double full_length = 4e-3, sliding_speed = 0.4;
  double before = 0;
  for (const int texels : {8, 16, 32, 64}) {
    const render::maps::SurfaceMap relief = sine_map(full_length, 1e-6, texels, 16);
    const Scrape scrape(render::maps::normal_map_of(relief), sliding_speed, 5, 1);
    motion::LastingForceOptions options = bare();
    const Eigen::VectorXd profile = normal_force(scrape, options);
    options.excitation = motion::ContactExcitation::texel_impulses;
    const Eigen::VectorXd steps = normal_force(scrape, options);
    const double frequency = sliding_speed / full_length;
    const std::complex<double> expected = line(profile, frequency);
    const double error = std::abs(line(steps, frequency) - expected) / std::abs(expected);
    RecordProperty("error_" + std::to_string(texels), std::to_string(error));
    if (before > 0) {
      EXPECT_NEAR(before / error, 4, 0.6) << texels;
    }
    before = error;
  }
  EXPECT_LT(before, 2e-3);
}

TEST(LastingForce, TheSolversImpulsesComeAsTheyAre) {
  Scrape scrape(sine_map(2e-3, 1e-5, 32, 16), 0.5, 2, 0.1);
  double sum = 0;
  int turn = 0;
  for (motion::ContactStep& step : scrape.motion.contacts[0].steps) {
    step.force = Vec3(0.3, 0, 1 + turn++ % 3);
    sum += step.force.z() * scrape.motion.step;
  }
  motion::LastingForceOptions options = bare();
  options.excitation = motion::ContactExcitation::solver_impulses;
  motion::LastingForces forces(scrape.motion, scrape.bodies, options);
  const motion::LastingForce force = forces.force(0);
  EXPECT_NEAR(force.force.row(2).sum() / audio_rate, sum, 1e-12);
  EXPECT_NEAR(force.force.row(0).sum() / audio_rate, 0.03, 1e-12);
}

// Roughness belongs to places: the same way over them, whenever, gives the same force.
TEST(LastingForce, RoughnessIsThatOfThePlaceAndInProportionToTheForce) {
  const render::maps::SurfaceMap map = sine_map(2e-3, 0, 16, 4);
  motion::LastingForceOptions options = bare();
  options.roughness = 0.1;
  const Scrape one(map, 0.3, 5, 0.2);
  const Eigen::VectorXd force = normal_force(one, options);
  EXPECT_EQ(force, normal_force(one, options));
  // Later by whole samples and steps.
  Scrape late = one;
  const std::size_t wait = 10;  // 441 samples
  late.motion.states.insert(late.motion.states.begin(), wait, one.motion.states.front());
  late.motion.contacts[0].first_step = wait;
  motion::LastingForces forces(late.motion, late.bodies, options);
  EXPECT_EQ(forces.force(0).first_sample, 441u);
  EXPECT_LT((normal_force(late, options) - force).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((normal_force(Scrape(map, 0.3, 10, 0.2), options) - 2 * force).cwiseAbs().maxCoeff(),
            1e-12);
  EXPECT_TRUE(normal_force(Scrape(map, 0, 5, 0.2), options).isZero(0));
  options.seed = 9;
  EXPECT_GT((normal_force(one, options) - force).norm(), force.norm());
}

// Twice as fast over the same way: the same course in half the time, as far as it holds waves that
// long.
TEST(LastingForce, RoughnessPlaysAsFastAsTheSlip) {
  const render::maps::SurfaceMap map = sine_map(2e-3, 0, 16, 4);
  motion::LastingForceOptions options = bare();
  options.roughness = 0.1;
  const Scrape slow(map, 0.01, 5, 0.2), fast(map, 0.02, 5, 0.1);
  motion::LastingForces a(slow.motion, slow.bodies, options), b(fast.motion, fast.bodies, options);
  const Eigen::VectorXd at_leisure = a.force(0).force.row(2), quick = b.force(0).force.row(2);
  double sum = 0, both = 0;
  for (Eigen::Index n = 500; n + 500 < quick.size(); ++n) {
    sum += std::pow(quick[n] - at_leisure[2 * n], 2);
    both += std::pow(at_leisure[2 * n], 2);
  }
  EXPECT_LT(sum / both, 0.03);
}

TEST(FractalNoise, HasUnitVarianceAndItsExponent) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-1, 1);
  for (const double exponent : {1.5, 2.5}) {
    const motion::FractalNoise noise(3, 1e-3, exponent);
    double sum = 0, squares = 0, both = 0;
    constexpr int places = 100000;
    for (int i = 0; i < places; ++i) {
      const Eigen::Vector2d pair = noise.at({place(random), place(random), place(random)}, 1e-9);
      const double value = pair[i % 2];
      both += pair[0] * pair[1];
      sum += value;
      squares += value * value;
    }
    EXPECT_NEAR(sum / places, 0, 0.01);
    EXPECT_NEAR(squares / places, 1, 0.02);
    EXPECT_NEAR(both / places, 0, 0.02);
    // Structure function: the mean square of differences over a distance goes with
    // distance^(exponent - 1) within the waves, for exponents below 3.
    const auto structure = [&](double distance) {
      double total = 0;
      for (int i = 0; i < places / 5; ++i) {
        const Vec3 at(place(random), place(random), place(random));
        total += (noise.at(at + Vec3(distance, 0, 0), 1e-9) - noise.at(at, 1e-9)).squaredNorm();
      }
      return total;
    };
    const double slope = std::log(structure(64e-6) / structure(1e-6)) / std::log(64.0);
    EXPECT_NEAR(slope, exponent - 1, 0.1) << exponent;
  }
  EXPECT_THROW(motion::FractalNoise(0, 0, 1.5), core::InputError);
  EXPECT_THROW(motion::FractalNoise(0, 1, 1), core::InputError);
}

TEST(TracedFace, WavesAreShallowerByTheBlur) {
  constexpr int texel_count = 32;
  const auto map =
      std::make_shared<const render::maps::SurfaceMap>(sine_map(2e-3, 1e-5, texel_count, 4));
  motion::TracedMaps maps;
  const motion::TracedFace face({map, Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), {1, 1}},
                                maps.of(map, 0));
  EXPECT_EQ(maps.of(map, 0), maps.of(map, 0));  // made once
  const auto amplitude = [&](double texels) {
    double high = -1, low = 1;
    for (int i = 0; i < 200; ++i) {
      const double h = face.detail({2e-3 * i / 200.0 + 0.013, 1e-3}, texels * map->texel).height;
      high = std::max(high, h);
      low = std::min(low, h);
    }
    return high - low;
  };
  const double whole = amplitude(0.5);
  for (const int width : {2, 4, 8, 16}) {
    const double ratio =
        std::sin(M_PI * width / texel_count) / (width * std::sin(M_PI / texel_count));
    EXPECT_NEAR(amplitude(width) / whole, std::pow(ratio, 4), 2e-3) << width;
  }
  EXPECT_NEAR(amplitude(32) / whole, 0, 1e-3);
  EXPECT_FALSE(face.place({0.5, 0.5, 0.01}));
  EXPECT_FALSE(face.place({1.5, 0.5, 0}));
  EXPECT_TRUE(face.place({0.5, 0.5, -1e-5}));
}

TEST(ContactPath, FollowsWhatMovesEvenlyAndBendsSmoothly) {
  std::vector<Vec3> points;
  for (int k = 0; k < 10; ++k) points.emplace_back(0.1 + 0.02 * k, -0.3 * k, 1);
  const motion::ContactPath path(points, 1e-3);
  for (const double time : {0.0, 0.0004, 0.005, 0.00931, 0.01}) {
    const motion::ContactPath::Place at = path.at(time);
    EXPECT_NEAR((at.point - Vec3(0.1 + 20 * time, -300 * time, 1)).norm(), 0, 1e-12);
    EXPECT_NEAR((at.velocity - Vec3(20, -300, 0)).norm(), 0, 1e-9);
    EXPECT_NEAR(at.acceleration.norm(), 0, 1e-6);
  }
  for (Vec3& point : points) point.y() = std::sin(point.x() * 20);
  const motion::ContactPath bent(points, 1e-3);
  for (const double time : {0.0013, 0.0035, 0.006, 0.0072}) {
    const auto at = bent.at(time);
    const Vec3 rate = (bent.at(time + 1e-7).point - bent.at(time - 1e-7).point) / 2e-7;
    const Vec3 bend = (bent.at(time + 1e-7).velocity - bent.at(time - 1e-7).velocity) / 2e-7;
    EXPECT_NEAR((at.velocity - rate).norm(), 0, 1e-5 * rate.norm());
    EXPECT_NEAR((at.acceleration - bend).norm(), 0, 1e-4 * bend.norm());
  }
  EXPECT_THROW(motion::ContactPath({}, 1e-3), core::InputError);
  EXPECT_THROW(motion::ContactPath({Vec3(NAN, 0, 0)}, 1e-3), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
