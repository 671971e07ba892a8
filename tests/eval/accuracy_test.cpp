// The convergence study's configuration, and what it makes of its measurements.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "eval/accuracy/detail/modes_line.hpp"
#include "eval/accuracy/findings.hpp"
#include "solvers/families/families.hpp"

namespace carillon::eval {
namespace {

accuracy::AccuracyConfig read(const std::string& text,
                              const std::vector<std::string>& overrides = {}) {
  return accuracy::read_accuracy_config(text, "study.yaml", overrides);
}

std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const core::ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(AccuracyConfig, DefaultsAreThoseOfTheDocumentation) {
  const accuracy::AccuracyConfig config = read("objects:\n  - shape: bowl\n");
  EXPECT_EQ(config.name, "study");
  EXPECT_EQ(config.band.max_modes, 24);
  EXPECT_EQ(config.band.min_frequency, 20);
  EXPECT_EQ(config.band.max_frequency, 200e3);
  EXPECT_EQ(config.tolerances, std::vector<double>{1e-12});
  EXPECT_EQ(config.pitch_targets, (std::vector<double>{1, 2, 5, 10, 20}));
  EXPECT_EQ(config.reference, accuracy::ReferenceSolver::automatic);
  EXPECT_FALSE(config.all_ranks || config.cpu_time);
  const accuracy::StudiedObject& bowl = config.objects.at(0);
  EXPECT_EQ(bowl.name, "bowl");
  EXPECT_EQ(bowl.material.name, "steel");
  EXPECT_EQ(bowl.orders, (std::vector<int>{1, 2, 3, 4}));
  EXPECT_EQ(bowl.size_factors, (std::vector<double>{1.5, 1, 0.7}));
  EXPECT_EQ(bowl.reference_factor, 0.5);
}

TEST(AccuracyConfig, AnObjectHasItsOwnWords) {
  const accuracy::AccuracyConfig config = read(
      "levels: {orders: [2, 3], element_size_factors: [1]}\nobjects:\n"
      "  - shape: tube\n    parameters: {wall: 2 mm}\n    materials: [glass]\n"
      "    levels: {orders: [4]}\n    reference: {element_size_factor: 0.4}\n"
      "  - mesh: scans/cup.ply\n    length: 10 cm\n    optional: true\n"
      "    stand_in: {shape: cup, deviation: 0.1 mm}\n",
      {"objects[0].levels.element_size_factors=[2, 1]", "modes.max_modes=8"});
  EXPECT_EQ(config.band.max_modes, 8);
  EXPECT_EQ(config.objects[0].request.shape.parameters.at("wall"), 0.002);
  EXPECT_EQ(config.objects[0].material.name, "glass");
  EXPECT_EQ(config.objects[0].orders, std::vector<int>{4});
  EXPECT_EQ(config.objects[0].reference_factor, 0.4);
  EXPECT_EQ(config.objects[0].size_factors, (std::vector<double>{2, 1}));
  const accuracy::StudiedObject& scan = config.objects[1];
  EXPECT_EQ(scan.name, "cup");
  EXPECT_EQ(scan.request.file.path, "scans/cup.ply");
  EXPECT_EQ(scan.request.file.length, 0.1);
  EXPECT_EQ(scan.orders, (std::vector<int>{2, 3}));
  ASSERT_TRUE(scan.stand_in);
  EXPECT_EQ(scan.stand_in->shape.family, "cup");
  EXPECT_EQ(scan.stand_in->deviation, 1e-4);
}

TEST(AccuracyConfig, AnObjectIsReadAsInABuild) {
  const accuracy::AccuracyConfig config = read(
      "materials: [glass]\nobjects:\n"
      "  - shape: bowl\n    name: one\n    parameters: {radius: [50 mm, 70 mm]}\n"
      "  - mesh: a.off\n    optional: true\n    thickness: 2 mm\n    any_size: true\n");
  EXPECT_DOUBLE_EQ(config.objects[0].request.shape.parameters.at("radius"), 0.06);
  EXPECT_EQ(config.objects[0].material.name, "glass");
  EXPECT_EQ(config.objects[1].request.file.thickness, 0.002);
  EXPECT_TRUE(config.objects[1].request.file.any_size);
  const std::string bowl = "objects:\n  - shape: bowl\n";
  EXPECT_NE(refusal(bowl + "    materials: [steel, glass]\n").find("one material"),
            std::string::npos);
  EXPECT_NEAR(
      solvers::families::extent_of(read(bowl + "    length: 10 cm\n").objects[0].request.shape)
          .longest_side,
      0.1, 1e-12);
  EXPECT_NE(refusal(bowl + "    length: 11 m\n").find("outside 1 mm to 10 m"), std::string::npos);
  EXPECT_EQ(refusal(bowl + "    length: 11 m\n    any_size: true\n"), "accepted");
  EXPECT_NE(refusal("objects:\n  - modelnet: folder\n").find("single objects"), std::string::npos);
  EXPECT_NE(refusal(bowl + "    count: 2\n").find("count: unknown key"), std::string::npos);
}

TEST(AccuracyConfig, KeysOfEarlierVersionsAreToldByTheirNewNames) {
  const std::string bowl = "objects:\n  - shape: bowl\n";
  EXPECT_NE(
      refusal(bowl + "sizes: [2, 1]\n").find("3:1: sizes: is now \"levels.element_size_factors\""),
      std::string::npos);
  EXPECT_NE(refusal(bowl + "    sizes: [2, 1]\n")
                .find("objects[0].sizes: is now \"objects[0].levels.element_size_factors\""),
            std::string::npos);
  EXPECT_NE(refusal(bowl + "    material: glass\n")
                .find("objects[0].material: is now \"objects[0].materials\""),
            std::string::npos);
  EXPECT_NE(refusal(bowl + "ranks: all\n").find("is now \"all_ranks\""), std::string::npos);
}

TEST(AccuracyConfig, ResolvedTextReadsBackAsItself) {
  const accuracy::AccuracyConfig once = read(
      "objects:\n  - shape: disc\n  - mesh: a.off\n    stand_in: {shape: ring, deviation: 1 mm}\n");
  EXPECT_EQ(read(once.resolved).resolved, once.resolved);
}

TEST(AccuracyConfig, MistakesAreNamed) {
  const std::string bowl = "objects:\n  - shape: bowl\n";
  EXPECT_NE(refusal("objects:\n  - shape: bowel\n").find("did you mean \"bowl\""),
            std::string::npos);
  EXPECT_NE(refusal(bowl + "levels: {order: [1]}\n").find("did you mean \"orders\""),
            std::string::npos);
  EXPECT_NE(refusal(bowl + "levels: {orders: [5]}\n").find("1 to 4"), std::string::npos);
  EXPECT_NE(refusal(bowl + "levels: {orders: [2.5]}\n").find("1 to 4"), std::string::npos);
  EXPECT_NE(refusal(bowl + "levels: {element_size_factors: [0]}\n").find("positive"),
            std::string::npos);
  EXPECT_NE(refusal(bowl + "levels: {element_size_factors: []}\n").find("no value"),
            std::string::npos);
  EXPECT_NE(refusal(bowl + "pitch_targets: [-5]\n").find("positive"), std::string::npos);
  EXPECT_NE(refusal(bowl + "    materials: stele\n").find("steel"), std::string::npos);
  EXPECT_NE(refusal(bowl + "  - shape: bowl\n").find("two objects"), std::string::npos);
  EXPECT_NE(refusal(bowl + "    mesh: a.obj\n").find("an object is"), std::string::npos);
  EXPECT_NE(refusal(bowl + "    parameters: {wall: 1 m}\n").find("study.yaml:"), std::string::npos);
  EXPECT_NE(refusal("modes: {max_modes: 3}\n").find("neither objects"), std::string::npos);
  EXPECT_NE(refusal("sound: {object: {shape: bowwl}}\n").find("bowl"), std::string::npos);
  EXPECT_NE(refusal("sound: {object: {shape: bowl}, image_orders: [1, 2]}\n").find("no room"),
            std::string::npos);
  EXPECT_NE(
      refusal("sound: {object: {shape: bowl}, mode_counts: [5, 3]}\n").find("each above the last"),
      std::string::npos);
  EXPECT_NE(refusal("features: {extractors: [magic]}\n").find("esprit"), std::string::npos);
}

TEST(AccuracyConfig, TheKeyThatIsWrongIsTheOneNamed) {
  const std::string bowl = "objects:\n  - shape: bowl\n";
  EXPECT_NE(refusal(bowl + "reference: {element_size_factor: -1}\n")
                .find("3:34: reference.element_size_factor: must be"),
            std::string::npos);
  EXPECT_NE(
      refusal(bowl + "modes: {min_frequency: -5 Hz}\n").find("3:24: modes.min_frequency: must not"),
      std::string::npos);
  EXPECT_NE(refusal(bowl + "modes: {max_frequency: 10 Hz}\n").find("max_frequency: must be above"),
            std::string::npos);
}

TEST(AccuracyConfig, WhatCannotBeMeasuredIsRefusedBeforeAnythingRuns) {
  const auto file = [](const std::string& words) {
    return refusal("objects:\n  - shape: bowl\n  - mesh: " + words + "\n");
  };
  EXPECT_NE(file("none.ply").find("study.yaml:3:11: objects[1].mesh: none.ply: no such file"),
            std::string::npos);
  EXPECT_EQ(file("none.ply\n    optional: true"), "accepted");
  EXPECT_NE(file("none.MSH\n    optional: true").find("elements of an MSH file"),
            std::string::npos);
  EXPECT_NE(file("none.blend\n    optional: true").find("no kind of mesh file"), std::string::npos);
  const std::string axisymmetric = "reference: {kind: axisymmetric}\nobjects:\n  - shape: bowl\n";
  EXPECT_EQ(refusal(axisymmetric), "accepted");
  EXPECT_NE(
      refusal(axisymmetric + "  - shape: block\n").find("4:12: objects[1].shape: block is not"),
      std::string::npos);
  EXPECT_NE(refusal(axisymmetric + "  - mesh: a.ply\n    optional: true\n").find("objects[1].mesh"),
            std::string::npos);
}

TEST(ModesLine, NamesTheBodyTheBandAndTheBounds) {
  const accuracy::AccuracyConfig config = read(
      "materials: ['youngs_modulus=70 GPa,poisson_ratio=0.3,density=2700']\nobjects:\n"
      "  - shape: disc\n    parameters: {radius: 60 mm, thickness: 5 mm}\n    materials: [steel]\n"
      "  - mesh: my cup's scan.ply\n    optional: true\n    length: 10 cm\n");
  const solvers::modes::Band band{0, 2500.5, 26};
  const std::string rest =
      " --min-frequency 0Hz --max-frequency 2500.5Hz --max-modes 26 --max-elements 40000 "
      "--max-unknowns 1000000000 --pitch-cents 2.5";
  EXPECT_EQ(
      accuracy::modes_line(config.objects[0], band, 40000, 2.5),
      "carillon modes disc:radius=0.06m,thickness=0.005m --solver tetrahedra --material steel" +
          rest);
  EXPECT_EQ(accuracy::modes_line(config.objects[1], band, 40000, 2.5),
            "carillon modes 'my cup'\\''s scan.ply' --length 0.1m --solver tetrahedra --material "
            "'youngs_modulus=70 GPa,poisson_ratio=0.3,density=2700'" +
                rest);
}

TEST(Findings, ErrorsAreDistancesInCents) {
  const std::vector<double> found = {202, 400, 900}, truth = {200, 400};
  const auto errors = accuracy::errors_in_cents(found, truth, 10);
  ASSERT_EQ(errors.size(), 2u);
  EXPECT_NEAR(errors[0], 1200 * std::log2(1.01), 1e-9);
  EXPECT_EQ(errors[1], 0);
  EXPECT_EQ(accuracy::errors_in_cents(found, truth, 1).size(), 1u);
  EXPECT_TRUE(accuracy::errors_in_cents({}, truth, 5).empty());
}

TEST(Findings, PairingByRankHasTheLeastTotalDistance) {
  EXPECT_TRUE(rc::check([] {
    const int count = *rc::gen::inRange(1, 6);
    std::vector<double> found, truth;
    for (int i = 0; i < count; ++i) {
      found.push_back(*rc::gen::inRange(100, 1000));
      truth.push_back(*rc::gen::inRange(100, 1000));
    }
    std::sort(found.begin(), found.end());
    std::sort(truth.begin(), truth.end());
    const auto total = [&](const std::vector<double>& reference) {
      double sum = 0;
      for (const double e : accuracy::errors_in_cents(found, reference, 10)) sum += std::abs(e);
      return sum;
    };
    const double by_rank = total(truth);
    std::vector<double> other = truth;
    do RC_ASSERT(by_rank <= total(other) + 1e-6);
    while (std::next_permutation(other.begin(), other.end()));
  }));
}

TEST(Findings, TheFrontHoldsWhatNothingBeats) {
  EXPECT_TRUE(rc::check([] {
    std::vector<accuracy::CostPoint> points(*rc::gen::inRange<std::size_t>(0, 30));
    for (accuracy::CostPoint& p : points) {
      p.seconds = *rc::gen::inRange(1, 12);
      p.cents = *rc::gen::inRange(1, 12);
    }
    const auto front = accuracy::pareto_front(points);
    const auto beats = [](const accuracy::CostPoint& a, const accuracy::CostPoint& b) {
      return a.seconds <= b.seconds && a.cents <= b.cents &&
             (a.seconds < b.seconds || a.cents < b.cents);
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool beaten =
          std::any_of(points.begin(), points.end(),
                      [&](const accuracy::CostPoint& p) { return beats(p, points[i]); });
      const bool on_front = std::any_of(front.begin(), front.end(), [&](std::size_t f) {
        return points[f].seconds == points[i].seconds && points[f].cents == points[i].cents;
      });
      RC_ASSERT(on_front == !beaten);
    }
    for (std::size_t i = 1; i < front.size(); ++i)
      RC_ASSERT(points[front[i]].seconds > points[front[i - 1]].seconds);
  }));
}

TEST(Findings, HalfTheErrorFollowsFromThePowerLaw) {
  for (const double power : {0.25, 0.5, 1.0}) {
    std::vector<accuracy::CostPoint> front;
    for (const double cents : {100.0, 30.0, 8.0, 1.5})
      front.push_back({3 * std::pow(cents, -power), cents});
    EXPECT_NEAR(*accuracy::cost_of_half_the_error(front), std::pow(2, power), 1e-12);
  }
  EXPECT_FALSE(accuracy::cost_of_half_the_error(std::vector<accuracy::CostPoint>{{1, 2}, {2, 1}}));
  EXPECT_FALSE(
      accuracy::cost_of_half_the_error(std::vector<accuracy::CostPoint>{{1, 2}, {2, 2}, {3, 2}}));
}

TEST(Findings, TheSameMeshAtAnotherToleranceIsNotBetter) {
  const std::vector<accuracy::CostPoint> points = {{1.2, 1.17000001}, {1.3, 1.17}, {1.5, 0.2}};
  EXPECT_EQ(accuracy::pareto_front(points), (std::vector<std::size_t>{0, 2}));
}

TEST(Findings, JsonTellsAFailureAndNothingElse) {
  accuracy::Findings findings;
  findings.name = "scan";
  findings.failure = "passed over, scan.ply is missing";
  findings.passed_over = true;
  const auto json = accuracy::to_json(findings);
  EXPECT_EQ(json.at("failure"), findings.failure);
  EXPECT_FALSE(json.contains("levels"));
  EXPECT_FALSE(accuracy::has_failed(findings));
  findings.passed_over = false;
  EXPECT_TRUE(accuracy::has_failed(findings));
}

TEST(Findings, OnlyRanksAboveTheBandsBottomAreCompared) {
  accuracy::Findings findings;
  findings.reference.frequencies = {50, 100, 200};
  findings.reference.first = 1;
  accuracy::RefinementLevel level;
  for (const double f : {70.0, 101.0, 204.0, 300.0}) {
    level.modes.eigenvalues.push_back(std::pow(2 * std::acos(-1) * f, 2));
    level.modes.pitch_errors.push_back(f);
  }
  findings.levels = {accuracy::compare({}, level, findings.reference)};
  const auto entry = accuracy::to_json(findings).at("levels").at(0);
  EXPECT_EQ(entry.at("modes"), 2);
  EXPECT_NEAR(entry.at("worst_cents"), 1200 * std::log2(1.02), 1e-6);
  EXPECT_NEAR(entry.at("median_cents"), 600 * (std::log2(1.01) + std::log2(1.02)), 1e-6);
  EXPECT_EQ(entry.at("estimated_errors_cents"), (std::vector<double>{101, 204}));
}

}  // namespace
}  // namespace carillon::eval
