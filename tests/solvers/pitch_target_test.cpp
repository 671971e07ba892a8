// The search for a setting that meets a pitch target, with made-up estimates of known behaviour.
#include "solvers/pitch/pitch_target.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <set>
#include <utility>

#include "core/error.hpp"
#include "family_shapes.hpp"
#include "solvers/pitch/pitch_model.hpp"
#include "test_meshes.hpp"

namespace carillon::test {
namespace {

using namespace solvers;

/// Errors [cent] of three modes as a function of a mesh.
using ErrorModel = std::function<std::vector<double>(const solvers::pitch::MeshSize&)>;

/// Eigenvalues of smooth modes: relative error (x h / p)^(2 p), the worst at `wave_number` [1/m].
ErrorModel smooth(double wave_number) {
  return [wave_number](const solvers::pitch::MeshSize& mesh) {
    std::vector<double> cents;
    for (const double fraction : {0.4, 0.7, 1.0}) {
      const double x = fraction * wave_number * mesh.element_size / mesh.order;
      cents.push_back(866 * std::pow(x, 2 * mesh.order));
    }
    return cents;
  };
}

/// Counts calls and solves by a model of errors.
struct Body {
  GeneratedShape shape;
  ErrorModel errors;
  int meshes = 0, solves = 0;
  std::vector<MeshOptions> asked;

  solvers::pitch::MeshMaker mesh_maker() {
    return [this](const MeshOptions& options) {
      ++meshes;
      asked.push_back(options);
      return solvers::families::mesh_family(shape, options);
    };
  }
  solvers::pitch::ModeSolver solver() {
    return [this](const MeshResult& made) {
      ++solves;
      const TetMesh& mesh = made.mesh;
      const solvers::pitch::MeshSize size = solvers::pitch::size_of(mesh);
      solvers::modes::Modes modes;
      modes.pitch_errors = errors(size);
      modes.eigenvalues.resize(modes.pitch_errors.size(), 1e8);
      modes.certificate.unknowns = 3 * static_cast<std::int64_t>(mesh.nodes.size());
      return std::vector<solvers::modes::Modes>{modes};
    };
  }
  solvers::pitch::PitchResult reach(const solvers::pitch::PitchTarget& target) {
    return solvers::pitch::reach_pitch(target, mesh_maker(), solver());
  }
};

Body tile(ErrorModel errors) {
  return {shape_of("tile", {{"length", 0.15}, {"width", 0.12}, {"thickness", 0.006}}),
          std::move(errors),
          0,
          0,
          {}};
}

Body block(ErrorModel errors) {
  return {shape_of("block", {{"length", 0.1}, {"width", 0.08}, {"height", 0.06}}),
          std::move(errors),
          0,
          0,
          {}};
}

Body cup(ErrorModel errors) {
  return {
      shape_of("cup",
               {{"radius", 0.0415}, {"bottom_radius", 0.03}, {"height", 0.105}, {"wall", 0.003}}),
      std::move(errors),
      0,
      0,
      {}};
}

TEST(PitchTarget, AFirstSettingGoodEnoughIsKept) {
  Body body = tile(smooth(20));
  const solvers::pitch::PitchResult result = body.reach({.cents = 5});
  EXPECT_TRUE(result.report.met());
  EXPECT_EQ(result.report.steps.size(), 1u);
  EXPECT_EQ(body.asked[0].order, 3);
  EXPECT_EQ(body.asked[0].element_size, 0);
  EXPECT_TRUE(result.report.steps[0].automatic_size);
  EXPECT_EQ(result.report.reached_cents, result.sets[0].pitch_errors[2]);
}

TEST(PitchTarget, RefinesUntilTheWorstModeMeetsIt) {
  for (const double cents : {20.0, 1.0, 0.2})
    for (Body body : {tile(smooth(90)), block(smooth(60))}) {
      const solvers::pitch::PitchResult result = body.reach({.cents = cents});
      const solvers::pitch::PitchReport& report = result.report;
      EXPECT_TRUE(report.met()) << report.stopped_by << ": " << report.reason;
      EXPECT_LE(report.reached_cents, cents);
      EXPECT_EQ(report.reached_cents, report.steps[report.chosen].worst_cents);
      // Errors follow the model, so one jump is enough; nothing is solved twice.
      EXPECT_LE(report.steps.size(), 3u) << body.shape.family << " " << cents;
      EXPECT_EQ(body.solves, static_cast<int>(report.steps.size()));
      EXPECT_EQ(body.meshes, body.solves);
      EXPECT_EQ(result.mesh.mesh.order, report.steps[report.chosen].order);
      EXPECT_EQ(static_cast<std::int64_t>(result.mesh.mesh.element_count()),
                report.steps[report.chosen].elements);
    }
}

TEST(PitchTarget, IsNoDearerThanNeeded) {
  // What it settles on is within a small factor of the cheapest setting on a fine grid of all. The
  // cup's automatic size of order 4, tried on the way, is much coarser than that of order 3.
  const ErrorModel errors = smooth(90);
  for (Body body : {tile(errors), cup(errors)}) {
    const double cents = body.shape.family == "cup" ? 5 : 1;
    const solvers::pitch::PitchResult result = body.reach({.cents = cents});
    ASSERT_TRUE(result.report.met());
    double cheapest = 1e300;
    for (int order = 2; order <= 4; ++order)
      for (int step = 0; step < 12; ++step) {
        const double size = 0.012 * std::pow(1.15, step);
        const solvers::pitch::MeshSize mesh =
            solvers::pitch::size_of(mesh_of(body.shape, order, size).mesh);
        if (errors(mesh)[2] <= cents)
          cheapest = std::min(cheapest, solvers::pitch::relative_cost(mesh));
      }
    EXPECT_LT(solvers::pitch::relative_cost(solvers::pitch::size_of(result.mesh.mesh)),
              2.5 * cheapest)
        << body.shape.family;
  }
}

TEST(PitchTarget, SlowConvergenceAtCornersIsNoticed) {
  // A notch adds h^1.09 at every order.
  Body body = tile([](const solvers::pitch::MeshSize& mesh) {
    auto cents = smooth(90)(mesh);
    cents[2] += 2 * std::pow(mesh.element_size / 0.02, 1.09);
    return cents;
  });
  const solvers::pitch::PitchResult result = body.reach({.cents = 0.8});
  EXPECT_TRUE(result.report.met()) << result.report.stopped_by;
  EXPECT_LE(result.report.steps.size(), 6u);
}

TEST(PitchTarget, SaysThatNothingHelps) {
  Body body = tile([](const solvers::pitch::MeshSize&) {
    return std::vector<double>{0.1, 0.2, 7};
  });
  const solvers::pitch::PitchResult result = body.reach({.cents = 5});
  EXPECT_EQ(result.report.stopped_by, "no_progress");
  EXPECT_NE(result.report.reason.find("7 cents"), std::string::npos);
  EXPECT_EQ(result.report.reached_cents, 7);
  EXPECT_EQ(result.report.steps.size(), 3u);
  EXPECT_EQ(result.sets.size(), 1u);
}

TEST(PitchTarget, StopsAtTheElementsAllowed) {
  Body body = tile(smooth(300));
  solvers::pitch::PitchTarget target{.cents = 0.01};
  target.start.max_elements = 3000;
  const solvers::pitch::PitchResult result = body.reach(target);
  EXPECT_EQ(result.report.stopped_by, "max_elements") << result.report.reason;
  EXPECT_NE(result.report.reason.find("3000"), std::string::npos);
  for (const solvers::pitch::PitchStep& step : result.report.steps) EXPECT_LE(step.elements, 3000);
  // The best the bound allows was tried.
  EXPECT_GT(result.report.steps.size(), 1u);
  EXPECT_LT(result.report.reached_cents, 0.5 * result.report.steps[0].worst_cents);
}

TEST(PitchTarget, StopsAtTheMemoryLimit) {
  Body body = block(smooth(600));
  solvers::pitch::PitchTarget target{.cents = 0.01};
  target.memory_limit = 200 << 20;
  const solvers::pitch::PitchResult result = body.reach(target);
  EXPECT_EQ(result.report.stopped_by, "memory_limit") << result.report.reason;
  EXPECT_LT(solvers::pitch::factor_memory(solvers::pitch::size_of(result.mesh.mesh)),
            1.5 * (200 << 20));
  // An iterative solver keeps no factor: elements are the bound then.
  target.linear_solver = solvers::modes::LinearSolver::iterative;
  target.start.max_elements = 20000;
  EXPECT_EQ(body.reach(target).report.stopped_by, "max_elements");
}

TEST(PitchTarget, AFailureAfterTheFirstStepKeepsWhatThereIs) {
  Body body = tile(smooth(90));
  const auto mesh = body.mesh_maker();
  const auto result = solvers::pitch::reach_pitch(
      {.cents = 0.1},
      [&](const MeshOptions& options) {
        if (body.meshes > 0) throw core::SolverError("the mesher gave up on it");
        return mesh(options);
      },
      body.solver());
  EXPECT_EQ(result.report.stopped_by, "mesher");
  EXPECT_NE(result.report.reason.find("gave up"), std::string::npos);
  EXPECT_EQ(result.report.steps.size(), 1u);
  EXPECT_GT(result.mesh.mesh.element_count(), 0u);

  const auto solve = body.solver();
  body.solves = 0;
  const auto unsolved =
      solvers::pitch::reach_pitch({.cents = 0.1}, body.mesh_maker(), [&](const MeshResult& m) {
        if (body.solves > 0) throw core::SolverError("no convergence");
        return solve(m);
      });
  EXPECT_EQ(unsolved.report.stopped_by, "solver");

  EXPECT_THROW(
      solvers::pitch::reach_pitch({.cents = 1}, body.mesh_maker(),
                                  [](const MeshResult&) -> std::vector<solvers::modes::Modes> {
                                    throw core::SolverError("no");
                                  }),
      core::SolverError);
}

/// Whether a machine is fast or large enough must not decide between two meshes.
TEST(PitchTarget, LackOfTimeOrMemoryIsNoReasonToSettleForLess) {
  Body body = tile(smooth(150));
  const auto mesh = body.mesh_maker();
  EXPECT_THROW(solvers::pitch::reach_pitch(
                   {.cents = 0.1},
                   [&](const MeshOptions& options) {
                     if (body.meshes > 0) throw core::TimeError("longer than 300 s");
                     return mesh(options);
                   },
                   body.solver()),
               core::TimeError);
  const auto solve = body.solver();
  body.solves = 0;
  EXPECT_THROW(solvers::pitch::reach_pitch({.cents = 0.1}, body.mesh_maker(),
                                           [&](const MeshResult& m) {
                                             if (body.solves > 0)
                                               throw core::MemoryError("out of memory");
                                             return solve(m);
                                           }),
               core::MemoryError);
}

TEST(PitchTarget, GivenElementsRiseInOrderAlone) {
  Body body = tile(smooth(150));
  solvers::pitch::PitchTarget target{.cents = 0.01, .start = {.order = 2}, .fixed_mesh = true};
  const MeshOptions coarse{.order = 2, .element_size = 0.03};
  const auto given = [&](const MeshOptions& options) {
    EXPECT_EQ(options.element_size, 0);
    MeshOptions at = coarse;
    at.order = options.order;
    return solvers::families::mesh_family(body.shape, at);
  };
  const auto result = solvers::pitch::reach_pitch(target, given, body.solver());
  EXPECT_EQ(result.report.stopped_by, "order") << result.report.reason;
  EXPECT_EQ(result.mesh.mesh.order, 4);
  for (const solvers::pitch::PitchStep& step : result.report.steps)
    EXPECT_EQ(step.elements, result.report.steps[0].elements);
}

TEST(PitchTarget, EverySetMustMeetIt) {
  Body body = tile(smooth(60));
  const auto result =
      solvers::pitch::reach_pitch({.cents = 2}, body.mesh_maker(), [&](const MeshResult& mesh) {
        auto sets = body.solver()(mesh);
        sets.push_back(sets[0]);
        sets[1].pitch_errors = smooth(120)(solvers::pitch::size_of(mesh.mesh));
        return sets;
      });
  ASSERT_TRUE(result.report.met());
  EXPECT_EQ(result.sets.size(), 2u);
  EXPECT_LE(result.sets[1].pitch_errors[2], 2);
}

/// The harder of two sets alone tells that a setting falls short.
TEST(PitchTarget, AProbeSparesTheOtherSets) {
  Body body = tile(smooth(60));
  int probed = 0;
  const auto both_with = [&](double wave_number) {
    return [&body, wave_number](const MeshResult& mesh) {
      auto sets = body.solver()(mesh);
      sets.push_back(sets[0]);
      sets[1].pitch_errors = smooth(wave_number)(solvers::pitch::size_of(mesh.mesh));
      return sets;
    };
  };
  const auto hardest_with = [&](double wave_number) {
    return [&probed, both = both_with(wave_number)](const MeshResult& mesh) {
      ++probed;
      return std::vector{both(mesh)[1]};
    };
  };
  const auto whole = solvers::pitch::reach_pitch({.cents = 2}, body.mesh_maker(), both_with(120));
  const int steps = body.solves;
  ASSERT_GT(steps, 1);
  body.solves = 0;
  int solved = 0;
  const auto counted = [&](const MeshResult& mesh) {
    ++solved;
    return both_with(120)(mesh);
  };
  const auto spared =
      solvers::pitch::reach_pitch({.cents = 2}, body.mesh_maker(), counted, hardest_with(120));
  EXPECT_TRUE(spared.report.met());
  EXPECT_EQ(spared.sets.size(), 2u);
  EXPECT_EQ(solved, 1);
  EXPECT_EQ(probed, steps);
  EXPECT_EQ(spared.report.reached_cents, whole.report.reached_cents);

  // A probe that was not the worst: all sets are judged where it meets the target.
  solved = 0;
  const auto misled =
      solvers::pitch::reach_pitch({.cents = 2}, body.mesh_maker(), counted, hardest_with(60));
  EXPECT_TRUE(misled.report.met());
  EXPECT_GT(solved, 1);
  EXPECT_LE(misled.sets[1].pitch_errors[2], 2);

  // Where the search gives up, the sets of the best setting are there all the same.
  solved = 0;
  const auto stopped = solvers::pitch::reach_pitch({.cents = 0.05, .max_unknowns = 30000},
                                                   body.mesh_maker(), counted, hardest_with(400));
  EXPECT_FALSE(stopped.report.met());
  EXPECT_EQ(solved, 1);
  EXPECT_EQ(stopped.sets.size(), 2u);
  EXPECT_EQ(stopped.report.reached_cents, stopped.report.steps[stopped.report.chosen].worst_cents);
  EXPECT_EQ(stopped.report.reached_cents,
            std::max(stopped.sets[0].pitch_errors[2], stopped.sets[1].pitch_errors[2]));
}

TEST(PitchTarget, ModesWithoutEstimatesAndNoModesAtAll) {
  Body body = tile([](const solvers::pitch::MeshSize&) { return std::vector<double>{}; });
  const auto empty = body.reach({.cents = 1}).report;
  EXPECT_TRUE(empty.met());  // no mode, no error: two settings say so
  EXPECT_EQ(empty.steps.size(), 2u);
  EXPECT_EQ(empty.reached_cents, 0);
  EXPECT_GT(empty.steps[1].unknowns, empty.steps[0].unknowns);
  // Modes that were too sharp to be found at first.
  Body sharp = tile([](const solvers::pitch::MeshSize& mesh) {
    return mesh.order == 1 ? std::vector<double>{} : std::vector<double>{0.5};
  });
  solvers::pitch::PitchTarget target{.cents = 1};
  target.start.order = 1;
  const auto found = sharp.reach(target);
  EXPECT_TRUE(found.report.met());
  EXPECT_EQ(found.sets[0].size(), 1u);
  EXPECT_THROW(solvers::pitch::reach_pitch({.cents = 1}, body.mesh_maker(),
                                           [](const MeshResult&) {
                                             solvers::modes::Modes modes;
                                             modes.eigenvalues = {1.0};
                                             return std::vector<solvers::modes::Modes>{modes};
                                           }),
               core::InputError);
  for (const double bad : {0.0, 0.009, -1.0, std::nan(""), HUGE_VAL})
    EXPECT_THROW(body.reach({.cents = bad}), core::InputError) << bad;
}

/// A plate in one layer of straight elements, which takes no time to make.
MeshResult plain_plate(const MeshOptions& options) {
  const double edge = options.element_size > 0 ? options.element_size : 0.03;
  const auto cells = [&](double side) { return static_cast<int>(std::ceil(1.5 * side / edge)); };
  const int x = cells(0.15), y = cells(0.12);
  if (6 * x * y > options.max_elements) throw core::LimitError("more than max_elements");
  MeshResult result;
  result.mesh = box_mesh({0.15, 0.12, 0.006}, {x, y, 1}, options.order);
  return result;
}

TEST(PitchTarget, AlwaysEndsAndTellsTheTruth) {
  EXPECT_TRUE(rc::check([] {
    const double wave_number = *rc::gen::inRange(10, 400);
    const double floor_cents = *rc::gen::element(0.0, 0.0, 0.3, 3.0);
    const double cents = *rc::gen::element(0.1, 1.0, 5.0, 20.0);
    Body body = tile([=](const solvers::pitch::MeshSize& mesh) {
      auto errors = smooth(wave_number)(mesh);
      for (double& e : errors) e += floor_cents;
      return errors;
    });
    solvers::pitch::PitchTarget target{.cents = cents};
    target.start.max_elements = 900;
    target.start.order = *rc::gen::inRange(1, 5);
    const solvers::pitch::PitchReport report =
        solvers::pitch::reach_pitch(target, plain_plate, body.solver()).report;
    RC_ASSERT(report.steps.size() <= 8u);
    RC_ASSERT(report.met() == (report.reached_cents <= solvers::pitch::trusted_share * cents));
    for (const solvers::pitch::PitchStep& step : report.steps)
      RC_ASSERT(report.reached_cents <= step.worst_cents);
    RC_ASSERT(report.met() || !report.reason.empty());
  }));
}

TEST(PitchTarget, LayersComeWhereInwardEdgesHoldASearchUp) {
  const auto layers_of = [](const std::string& family, double cents) {
    int layers = 0;
    const auto make_mesh = [&](const MeshOptions& options) {
      layers = options.edge_layers;
      return solvers::families::mesh_family(shape_at(find_family(family)), options);
    };
    const auto solve = [&](const MeshResult& made) {
      solvers::modes::Modes modes;
      modes.pitch_errors = {12 * std::pow(6, -layers)};
      modes.eigenvalues = {1e8};
      modes.certificate.unknowns = 3 * static_cast<std::int64_t>(made.mesh.nodes.size());
      return std::vector<solvers::modes::Modes>{modes};
    };
    std::vector<int> asked;
    for (const auto& step :
         solvers::pitch::reach_pitch({.cents = cents}, make_mesh, solve).report.steps)
      asked.push_back(step.edge_layers);
    return asked;
  };
  // The edges of a cavity turn inward, those of a block do not.
  EXPECT_EQ(layers_of("box", 5), std::vector<int>({1}));
  EXPECT_EQ(layers_of("box", 1), std::vector<int>({1, 2}));
  EXPECT_EQ(layers_of("box", 0.1), std::vector<int>({1, 4}));
  for (const int layers : layers_of("block", 0.1)) EXPECT_EQ(layers, 1);
}

TEST(PitchTarget, SizesThatGiveFewerElementsThanExpectedAreAskedSmaller) {
  // The automatic size refines where a body is thin; a size that is given does not.
  Body body = tile(smooth(90));
  const auto coarser = [&body](MeshOptions options) {
    if (options.element_size > 0) options.element_size *= 3;
    return body.mesh_maker()(options);
  };
  const auto reach = [&](double cents) {
    return solvers::pitch::reach_pitch({.cents = cents}, coarser, body.solver()).report;
  };
  const double first = reach(1e3).reached_cents;
  // Nearly there: fewer elements of order 4 should do.
  const solvers::pitch::PitchReport report = reach(first);
  EXPECT_TRUE(report.met()) << report.stopped_by << ": " << report.reason;
  ASSERT_GE(report.steps.size(), 3u);
  EXPECT_GT(report.steps[1].worst_cents, first);
}

TEST(PitchTarget, MeshesLargerThanAllowedAreNotSolved) {
  // Smaller sizes follow more of a scan's detail: ten times the elements that were expected.
  Body body = tile(smooth(90));
  const auto finer = [&body](MeshOptions options) {
    if (options.element_size > 0) options.element_size *= 0.3;
    return body.mesh_maker()(options);
  };
  const solvers::pitch::PitchReport report =
      solvers::pitch::reach_pitch({.cents = 0.01, .max_unknowns = 60000}, finer, body.solver())
          .report;
  EXPECT_FALSE(report.met());
  EXPECT_EQ(report.stopped_by, "max_unknowns");
  EXPECT_GT(body.meshes, body.solves);
  // The automatic size has the elements that it had, at any order.
  ASSERT_GE(report.steps.size(), 2u);
  EXPECT_TRUE(report.steps[1].automatic_size);
  EXPECT_EQ(report.steps[1].order, 4);
  for (const solvers::pitch::PitchStep& step : report.steps) EXPECT_LE(step.unknowns, 75000);
}

TEST(PitchTarget, AFirstSettingAboveTheUnknownsAllowedIsSolvedAtALowerOrder) {
  const auto reach = [](const MeshOptions& start, std::int64_t max_unknowns) {
    Body body = tile(smooth(90));
    return body.reach({.cents = 0.1, .start = start, .max_unknowns = max_unknowns}).report;
  };
  const auto first = [](const solvers::pitch::PitchReport& report) { return report.steps.front(); };
  MeshOptions start;
  start.element_size = 0.01;
  const std::int64_t third = first(reach(start, 1'000'000)).unknowns;
  EXPECT_EQ(first(reach(start, third)).order, 3);
  const solvers::pitch::PitchReport lower = reach(start, third / 2);
  EXPECT_EQ(first(lower).order, 2);
  EXPECT_LT(first(lower).unknowns, third / 2);
  // The lowest order is solved whatever it takes: something has to be.
  EXPECT_EQ(first(reach(start, third / 10)).order, 2);
  start.order = 4;
  EXPECT_EQ(first(reach(start, third)).order, 3);
}

TEST(PitchTarget, ElementsAreNotSolvedTwice) {
  // Inward edges hold the search up, but the mesher leaves out the layers that would help.
  int solves = 0;
  const auto make_mesh = [](MeshOptions options) {
    options.element_size = 0;
    return solvers::families::mesh_family(shape_at(find_family("box")), options);
  };
  const auto solve = [&solves](const MeshResult& made) {
    ++solves;
    solvers::modes::Modes modes;
    modes.pitch_errors = {50.0 - made.mesh.order};
    modes.eigenvalues = {1e8};
    modes.certificate.unknowns = 3 * static_cast<std::int64_t>(made.mesh.nodes.size());
    return std::vector<solvers::modes::Modes>{modes};
  };
  const auto report = solvers::pitch::reach_pitch({.cents = 1}, make_mesh, solve).report;
  EXPECT_FALSE(report.met());
  EXPECT_EQ(solves, static_cast<int>(report.steps.size()));
  std::set<std::pair<int, std::int64_t>> solved;
  for (const solvers::pitch::PitchStep& step : report.steps)
    EXPECT_TRUE(solved.insert({step.order, step.elements}).second)
        << "order " << step.order << ", " << step.elements << " elements, " << step.edge_layers
        << " layers";
}

TEST(PitchTarget, AFifthIsKeptForEstimates) {
  for (const auto& [worst, met] : {std::pair(3.9, true), std::pair(4.1, false)}) {
    Body body = tile(
        [worst = worst](const solvers::pitch::MeshSize&) { return std::vector<double>{worst}; });
    const auto report = body.reach({.cents = 5}).report;
    EXPECT_EQ(report.met(), met);
    EXPECT_EQ(report.reason.find("a fifth too low") == std::string::npos, met) << report.reason;
  }
}

TEST(PitchTarget, JsonNamesStepsAndWhatStoppedIt) {
  Body body = tile(smooth(90));
  const solvers::pitch::PitchReport report = body.reach({.cents = 1}).report;
  const auto json = solvers::pitch::to_json(report, true);
  EXPECT_EQ(json.at("asked_cents"), 1.0);
  EXPECT_LE(json.at("reached_cents").get<double>(), 1);
  EXPECT_TRUE(json.at("stopped_by").is_null());
  ASSERT_EQ(json.at("steps").size(), report.steps.size());
  for (const char* key : {"order", "element_size_m", "unknowns", "seconds", "worst_cents"})
    EXPECT_TRUE(json.at("steps")[0].contains(key)) << key;
  EXPECT_FALSE(solvers::pitch::to_json(report, false).at("steps")[0].contains("seconds"));
}

}  // namespace
}  // namespace carillon::test
