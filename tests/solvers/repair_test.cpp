// Repair: bodies whose volume is known, damaged in known ways.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "solvers/mesh/repair/detail/repair_steps.hpp"
#include "solvers/mesh/repair/repair.hpp"
#include "tests/solvers/prisms.hpp"
#include "tests/solvers/repaired.hpp"

namespace carillon::solvers {
namespace {

using namespace test;  // NOLINT: bodies and damages
using core::InputError;

TEST(Repair, ReturnsCleanBodiesBitForBit) {
  for (const Body& body : bodies()) {
    const Outcome outcome = repaired(body.mesh);
    EXPECT_TRUE(outcome.report.used_as_is);
    EXPECT_TRUE(outcome.report.actions.empty());
    EXPECT_EQ(outcome.body.vertices, body.mesh.vertices);
    EXPECT_EQ(outcome.body.triangles, body.mesh.triangles);
  }
}

TEST(Repair, BringsDamagedBodiesBackWithinOnePercent) {
  const auto all = bodies();
  EXPECT_TRUE(rc::check("volume within 1 %", [&all] {
    const Body& body = all[*rc::gen::inRange<std::size_t>(0, all.size())];
    std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
    mesh::SurfaceMesh mesh = body.mesh;
    // Each kind of damage once or not at all, in any order.
    std::vector<Damage> damages{Damage::dropped, Damage::flipped, Damage::doubled, Damage::seams};
    std::shuffle(damages.begin(), damages.end(), random);
    damages.resize(*rc::gen::inRange<std::size_t>(1, 5));
    for (const Damage damage : damages) mesh = damaged(mesh, damage, 0.01, random);
    const Outcome outcome = repaired(mesh);
    const double change = mesh::signed_volume(outcome.body) / mesh::signed_volume(body.mesh) - 1;
    RC_CLASSIFY(says(outcome.report, "wrap"), "wrapped");
    RC_ASSERT(std::abs(change) < 0.01);
  }));
}

TEST(Repair, ClosesCracksAndDoesNotTouchTheRest) {
  mesh::SurfaceMesh mesh = sphere_surface(0.05, 8);
  std::mt19937_64 random(3);
  mesh = damaged(mesh, Damage::seams, 0.2, random);
  for (std::size_t v = mesh.vertices.size() - 50; v < mesh.vertices.size(); ++v) {
    mesh.vertices[v] += Vec3(2e-8, -1e-8, 1e-8);
  }
  const Outcome outcome = repaired(mesh);
  EXPECT_NEAR(mesh::signed_volume(outcome.body), mesh::signed_volume(sphere_surface(0.05, 8)),
              1e-10);
  EXPECT_FALSE(says(outcome.report, "wrap"));
  EXPECT_EQ(outcome.body.vertices.size(), sphere_surface(0.05, 8).vertices.size());
}

TEST(Repair, TurnsInsideOutBodiesAndKeepsCavities) {
  const mesh::SurfaceMesh outer = sphere_surface(0.05, 8);
  const mesh::SurfaceMesh inner = sphere_surface(0.03, 6);
  const double solid = mesh::signed_volume(outer);
  EXPECT_EQ(mesh::signed_volume(repaired(turned_over(outer)).body), solid);
  // A hollow ball whose skins both look the wrong way.
  const Outcome hollow = repaired(together(turned_over(outer), inner));
  EXPECT_NEAR(mesh::signed_volume(hollow.body), solid - mesh::signed_volume(inner), 1e-12);
  // Skins that look the same way: the inner body lies in material that is there already.
  const Outcome swallowed = repaired(together(outer, inner));
  EXPECT_NEAR(mesh::signed_volume(swallowed.body), solid, 1e-12);
  EXPECT_TRUE(says(swallowed.report, "inside the material"));
}

TEST(Repair, UnitesBodiesThatMeet) {
  const mesh::SurfaceMesh box = box_surface(Vec3(1, 1, 1), 2);
  const Outcome overlap = repaired(together(box, moved(box, Vec3(0.5, 0.25, 0.3))));
  EXPECT_NEAR(mesh::signed_volume(overlap.body), 2 - 0.5 * 0.75 * 0.7, 1e-9);
  EXPECT_TRUE(says(overlap.report, "united"));
  // Face on face, with edges that do not fit.
  const Outcome stacked = repaired(together(box, moved(box, Vec3(1, 0.25, 0.3))));
  EXPECT_NEAR(mesh::signed_volume(stacked.body), 2, 1e-9);
  EXPECT_EQ(mesh::repair::diagnose(stacked.body).components, 1);
}

TEST(Repair, KeepsSeparatePiecesAndSaysSo) {
  const mesh::SurfaceMesh box = box_surface(Vec3(1, 1, 1), 2);
  const mesh::SurfaceMesh two = together(box, moved(box, Vec3(3, 0, 0)));
  EXPECT_TRUE(repaired(two).report.used_as_is);
  std::mt19937_64 random(4);
  const Outcome outcome = repaired(damaged(two, Damage::flipped, 0.05, random));
  EXPECT_NEAR(mesh::signed_volume(outcome.body), 2, 1e-12);
  EXPECT_TRUE(says(outcome.report, "2 closed surfaces"));
}

TEST(Repair, RefusesBodiesThatOnlyTouch) {
  // Nothing says whether they are joined in an edge or a point, or how strongly.
  const mesh::SurfaceMesh box = box_surface(Vec3(1, 1, 1), 2);
  EXPECT_NE(refusal(together(box, moved(box, Vec3(1, 1, 0)))).find("touch in an edge or a point"),
            std::string::npos);
  EXPECT_NE(refusal(together(box, moved(box, Vec3(1, 1, 1)))).find("touch in an edge or a point"),
            std::string::npos);
  // An edge that lies across a face.
  EXPECT_NE(refusal(together(box, moved(box, Vec3(1, 1, 0.3)))).find("touch in an edge or a point"),
            std::string::npos);
  const mesh::SurfaceMesh ball = sphere_surface(0.05, 8);
  EXPECT_NE(refusal(together(ball, moved(ball, Vec3(0, 0, 0.1)))).find("touch in an edge"),
            std::string::npos);
}

TEST(Repair, BelievesOrientationBeforeItUnites) {
  // A cup whose cavity pokes out at the top.
  const mesh::SurfaceMesh outer = box_surface(Vec3(0.06, 0.06, 0.05), 2);
  const mesh::SurfaceMesh inner =
      moved(box_surface(Vec3(0.05, 0.05, 0.047), 2), Vec3(0.005, 0.005, 0.005));
  const double walls = 0.06 * 0.06 * 0.05 - 0.05 * 0.05 * 0.045;
  const Outcome cup = repaired(together(outer, turned_over(inner)));
  EXPECT_NEAR(mesh::signed_volume(cup.body), walls, 1e-12);
  EXPECT_TRUE(says(cup.report, "cavities"));
  // The same read inside out.
  EXPECT_NEAR(mesh::signed_volume(repaired(together(turned_over(outer), inner)).body), walls,
              1e-12);
  // A box that only meets the other with little of it was turned by mistake.
  const mesh::SurfaceMesh box = box_surface(Vec3(1, 1, 1), 2);
  const Outcome stack = repaired(together(box, turned_over(moved(box, Vec3(0.9, 0.25, 0.3)))));
  EXPECT_NEAR(mesh::signed_volume(stack.body), 2 - 0.1 * 0.75 * 0.7, 1e-9);
}

mesh::SurfaceMesh pipe_sheet(int sides, const Vec3& at = Vec3::Zero()) {
  mesh::SurfaceMesh pipe;
  for (std::int32_t i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    for (const double z : {0.0, 0.1})
      pipe.vertices.push_back(at + Vec3(0.01 * std::cos(angle), 0.01 * std::sin(angle), z));
    const std::int32_t next = (i + 1) % sides;
    pipe.triangles.push_back({2 * i, 2 * next, 2 * i + 1});
    pipe.triangles.push_back({2 * next, 2 * next + 1, 2 * i + 1});
  }
  return pipe;
}

/// With its upper end closed.
mesh::SurfaceMesh capped(mesh::SurfaceMesh pipe) {
  const auto sides = static_cast<std::int32_t>(pipe.vertices.size() / 2);
  for (std::int32_t i = 1; i + 1 < sides; ++i) pipe.triangles.push_back({1, 2 * i + 1, 2 * i + 3});
  return pipe;
}

TEST(Repair, EveryPieceMayBeASheet) {
  // Chimes of three pipes, and a pipe beside a body.
  mesh::SurfaceMesh chimes = pipe_sheet(8);
  for (const double x : {0.05, 0.1}) chimes = together(chimes, pipe_sheet(8, Vec3(x, 0, 0)));
  EXPECT_NE(refusal(chimes).find("sheet"), std::string::npos);
  EXPECT_NE(refusal(chimes).find("thickness"), std::string::npos);
  const mesh::SurfaceMesh beside =
      together(box_surface(Vec3(0.05, 0.05, 0.01), 2), pipe_sheet(16, Vec3(0.1, 0.02, 0)));
  EXPECT_NE(refusal(beside).find("thickness"), std::string::npos);
  // One that ends in the body is its leg.
  const mesh::SurfaceMesh leg = together(box_surface(Vec3(0.05, 0.05, 0.02), 2),
                                         moved(capped(pipe_sheet(16)), Vec3(0.025, 0.025, 0.01)));
  const Outcome outcome = repaired(leg);
  EXPECT_NEAR(
      mesh::signed_volume(outcome.body) /
          (0.05 * 0.05 * 0.02 + 16 * 0.5 * 1e-4 * std::sin(2 * std::numbers::pi / 16) * 0.09),
      1, 1e-9);
}

TEST(Repair, TellsHowMuchWasFilled) {
  // A jar as one sheet: a flat shoulder about a mouth of 30 x 30 mm.
  mesh::SurfaceMesh jar = box_surface(Vec3(0.06, 0.06, 0.05), 4);
  std::erase_if(jar.triangles, [&jar](const mesh::Triangle& t) {
    Vec3 middle = Vec3::Zero();
    for (const std::int32_t v : t) middle += jar.vertices[static_cast<std::size_t>(v)] / 3;
    return middle.z() > 0.0499 && (middle - Vec3(0.03, 0.03, 0.05)).cwiseAbs().maxCoeff() < 0.015;
  });
  const Outcome outcome = repaired(jar);
  EXPECT_NEAR(outcome.report.filled_area, 9e-4 / (2 * 36e-4 + 4 * 30e-4), 1e-9);
}

TEST(Repair, NestedSurfacesThatAllLookOutward) {
  const auto box = [](double side) {
    return moved(box_surface(Vec3::Constant(side), 2), Vec3::Constant(-side / 2));
  };
  const Outcome outcome = repaired(together(together(box(0.1), box(0.08)), box(0.04)));
  EXPECT_NEAR(mesh::signed_volume(outcome.body), 1e-3, 1e-12);
  EXPECT_EQ(outcome.report.swallowed_surfaces, 2);
  // A hollow with a core in it.
  EXPECT_NEAR(outcome.report.swallowed_volume, 0.08 * 0.08 * 0.08 - 0.04 * 0.04 * 0.04, 1e-12);
}

TEST(Repair, AWrapMendsNoNoiseAtThePriceOfASlit) {
  // A bar of 100 x 21 x 6 mm with a slit of 0.2 mm, and a face whose vertices were moved about
  // within it so that its triangles overlap.
  const mesh::SurfaceMesh slit = prism({{0, 0},
                                        {0.1, 0},
                                        {0.1, 0.021},
                                        {0.0501, 0.021},
                                        {0.0501, 0.013},
                                        {0.0499, 0.013},
                                        {0.0499, 0.021},
                                        {0, 0.021}},
                                       0.006);
  mesh::SurfaceMesh noisy = slit;
  std::erase_if(noisy.triangles, [&noisy](const mesh::Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&noisy](std::int32_t v) {
      return noisy.vertices[static_cast<std::size_t>(v)].y() == 0;
    });
  });
  // The long side, in its place, as a grid.
  constexpr int across = 60, up = 6;
  const auto first = static_cast<std::int32_t>(noisy.vertices.size());
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> away(-0.0015, 0.0015);
  for (int j = 0; j <= up; ++j)
    for (int i = 0; i <= across; ++i) {
      Vec3 at(0.1 * i / across, 0, 0.006 * j / up);
      if (i > 6 && i < 24 && j > 0 && j < up) at += Vec3(away(random), 0, away(random));
      noisy.vertices.push_back(at);
    }
  for (std::int32_t j = 0; j < up; ++j)
    for (std::int32_t i = 0; i < across; ++i) {
      const std::int32_t a = first + j * (across + 1) + i, b = a + 1, c = a + across + 1;
      noisy.triangles.push_back({a, b, c});
      noisy.triangles.push_back({b, c + 1, c});
    }
  try {
    const Outcome outcome = repaired(noisy);
    // The slit is 8e-4 of it.
    EXPECT_NEAR(mesh::signed_volume(outcome.body) / mesh::signed_volume(slit), 1, 2e-4);
  } catch (const InputError& error) {
    EXPECT_NE(error.message().find("a wrap would close gaps"), std::string::npos);
  }
}

TEST(Repair, ClosesAFaceAndNoMouth) {
  // A face that lost most of itself, and a pipe that never had ends.
  mesh::SurfaceMesh box = box_surface(Vec3(0.1, 0.02, 0.006), 10);
  std::erase_if(box.triangles, [&box](const mesh::Triangle& t) {
    const Vec3 middle = (box.vertices[static_cast<std::size_t>(t[0])] +
                         box.vertices[static_cast<std::size_t>(t[1])] +
                         box.vertices[static_cast<std::size_t>(t[2])]) /
                        3;
    return middle.z() > 0.0059 && middle.x() > 0.08;
  });
  const Outcome closed = repaired(box);
  EXPECT_NEAR(mesh::signed_volume(closed.body), 0.1 * 0.02 * 0.006, 1e-12);
  EXPECT_TRUE(says(closed.report, "filled 1 hole"));
  for (const int sides : {4, 6, 8, 40}) {
    const mesh::SurfaceMesh pipe = pipe_sheet(sides);
    EXPECT_NE(refusal(pipe).find("sheet"), std::string::npos) << sides;
    EXPECT_GT(mesh::signed_volume(repaired(pipe, 0.001).body), 0);
  }
}

TEST(Repair, TellsAWrapThatClosesASlot) {
  // Two prongs with a slot of 1 mm between them: a wrap of the usual tolerance closes it, one of
  // 0.4 times that does not.
  const mesh::SurfaceMesh fork = prism({{0, 0},
                                        {0.1, 0},
                                        {0.1, 0.021},
                                        {0, 0.021},
                                        {0, 0.011},
                                        {0.075, 0.011},
                                        {0.075, 0.01},
                                        {0, 0.01}},
                                       0.006);
  const double usual = 0.002 * mesh::bounding_box(fork.vertices).extent().norm();
  const auto misplaced = [&fork](double offset) {
    const mesh::SurfaceMesh wrap = mesh::repair::alpha_wrap(fork, 5 * offset, offset);
    return mesh::repair::misplaced_points(fork, mesh::repair::shrink_onto(wrap, fork), offset,
                                          5 * offset);
  };
  EXPECT_GT(misplaced(usual).share, 0.05);
  EXPECT_GT(misplaced(usual).facing, 0.05);
  EXPECT_NEAR(misplaced(usual).width, 0.001, 1e-5);
  EXPECT_LT(misplaced(0.4 * usual).share, 0.01);
  EXPECT_LT(misplaced(0.4 * usual).facing, 0.003);
  EXPECT_EQ(mesh::repair::misplaced_points(fork, fork, usual, 5 * usual).share, 0);
}

TEST(Repair, DropsInnerWallsAndFins) {
  // A wall of double triangles across the middle of a box bounds nothing.
  SurfaceMesh box = box_surface(Vec3(1, 1, 1), 2);
  const auto at = [&box](double x, double y, double z) {
    for (std::size_t v = 0; v < box.vertices.size(); ++v) {
      if (box.vertices[v] == Vec3(x, y, z)) return static_cast<std::int32_t>(v);
    }
    ADD_FAILURE() << "no such vertex";
    return std::int32_t{0};
  };
  const std::int32_t rim[] = {at(0.5, 0, 0), at(0.5, 1, 0), at(0.5, 1, 1), at(0.5, 0, 1)};
  const std::int32_t middle[] = {at(0.5, 0.5, 0), at(0.5, 1, 0.5), at(0.5, 0.5, 1),
                                 at(0.5, 0, 0.5)};
  box.vertices.emplace_back(0.5, 0.5, 0.5);
  const auto centre = static_cast<std::int32_t>(box.vertices.size()) - 1;
  for (std::size_t i = 0; i < 4; ++i) {
    for (const auto& [a, b] : {std::pair(rim[i], middle[i]), {middle[i], rim[(i + 1) % 4]}}) {
      box.triangles.push_back({centre, a, b});
      box.triangles.push_back({centre, b, a});
    }
  }
  const Outcome outcome = repaired(box);
  EXPECT_NEAR(mesh::signed_volume(outcome.body), 1, 1e-12);
  EXPECT_EQ(mesh::repair::diagnose(outcome.body).components, 1);
  EXPECT_FALSE(says(outcome.report, "wrap"));
}

TEST(Repair, GivesSheetsAThickness) {
  // The outer skin of a bowl: half a sphere without a lid.
  SurfaceMesh sheet = sphere_surface(0.05, 12);
  std::erase_if(sheet.triangles, [&sheet](const mesh::Triangle& t) {
    double height = 0;
    for (const std::int32_t v : t) height += sheet.vertices[static_cast<std::size_t>(v)].z();
    return height > 0;
  });
  EXPECT_NE(refusal(sheet).find("thickness"), std::string::npos);
  const Outcome outcome = repaired(sheet, 0.003);
  EXPECT_NEAR(mesh::signed_volume(outcome.body), mesh::area(sheet) * 0.003,
              0.02 * mesh::area(sheet) * 0.003);
  EXPECT_TRUE(says(outcome.report, "thickness"));

  // A flat square, and one that is folded sharply: offsets would meet inside the fold.
  SurfaceMesh flat;
  flat.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_NE(refusal(flat).find("flat"), std::string::npos);
  EXPECT_NEAR(mesh::signed_volume(repaired(flat, 0.002).body), 0.01 * 0.002, 1e-12);
  flat.vertices.emplace_back(0.002, 0.05, 0.01);
  flat.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}};
  EXPECT_GT(mesh::signed_volume(repaired(flat, 0.004).body), 0.8 * mesh::area(flat) * 0.004);
}

TEST(Repair, RefusesHeapsOfTriangles) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> place(0, 1);
  mesh::SurfaceMesh heap;
  for (int i = 0; i < 300; ++i)
    heap.vertices.emplace_back(place(random), place(random), place(random));
  for (std::int32_t i = 0; i < 300; i += 3) heap.triangles.push_back({i, i + 1, i + 2});
  EXPECT_NE(refusal(heap).find("loose"), std::string::npos);
  mesh::SurfaceMesh line;
  line.vertices = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  line.triangles = {{0, 1, 2}};
  EXPECT_NE(refusal(line).find("no area"), std::string::npos);
}

TEST(Repair, KeepsTheWallsOfWhatItWraps) {
  // The bowl's wall is 2 % of its diagonal; a plain wrap at 0.2 % on either side adds a fifth.
  const mesh::SurfaceMesh bowl = bowl_surface(0.07, 0.004, 12);
  const double diagonal = mesh::bounding_box(bowl.vertices).extent().norm();
  const mesh::SurfaceMesh wrap = mesh::repair::alpha_wrap(bowl, 0.01 * diagonal, 0.002 * diagonal);
  const double volume = mesh::signed_volume(bowl);
  EXPECT_GT(mesh::signed_volume(wrap), 1.1 * volume);
  const mesh::SurfaceMesh shrunk = mesh::repair::shrink_onto(wrap, bowl);
  EXPECT_NEAR(mesh::signed_volume(shrunk) / volume, 1, 0.01);
  EXPECT_TRUE(mesh::repair::diagnose(shrunk).clean);
}

TEST(Repair, RefusesNonsenseOptions) {
  mesh::MeshFile file;
  mesh::Diagnosis diagnosis;
  mesh::RepairReport report;
  const mesh::SurfaceMesh broken = turned_over(sphere_surface(0.05, 4));
  file.wrap_tolerance = 0;
  EXPECT_THROW(mesh::repair::repair(broken, file, diagnosis, report), InputError);
  file.wrap_tolerance = 0.002;
  file.thickness = std::nan("");
  EXPECT_THROW(mesh::repair::repair(broken, file, diagnosis, report), InputError);
}

TEST(Repair, EndsInABodyOrAReasonForAnyTriangles) {
  // Few places and many triangles: every kind of degeneracy, most of them at once.
  std::mt19937_64 random(21);
  int made = 0;
  for (int round = 0; round < 60; ++round) {
    mesh::SurfaceMesh mesh;
    const auto vertices = static_cast<std::int32_t>(4 + random() % 12);
    for (std::int32_t v = 0; v < vertices; ++v) {
      const auto coordinate = [&random] { return 0.01 * static_cast<double>(random() % 3); };
      mesh.vertices.emplace_back(coordinate(), coordinate(), coordinate());
    }
    for (std::size_t t = 4 + random() % 40; t > 0; --t) {
      const auto any = [&] { return static_cast<std::int32_t>(random() % vertices); };
      mesh.triangles.push_back({any(), any(), any()});
    }
    mesh::MeshFile file;
    file.wrap_tolerance = 0.02;
    file.thickness = round % 3 == 0 ? 0.004 : 0;
    mesh::Diagnosis diagnosis;
    mesh::RepairReport report;
    try {
      EXPECT_TRUE(
          mesh::repair::diagnose(mesh::repair::repair(mesh, file, diagnosis, report)).clean);
      ++made;
    } catch (const InputError& error) {
      EXPECT_FALSE(error.message().empty());
    }
  }
  EXPECT_GT(made, 0);
}

TEST(Repair, IsDeterministic) {
  std::mt19937_64 random(11);
  mesh::SurfaceMesh mesh = damaged(torus_surface(0.04, 0.015, 12), Damage::dropped, 0.03, random);
  mesh = damaged(mesh, Damage::flipped, 0.03, random);
  const Outcome first = repaired(mesh);
  const Outcome second = repaired(mesh);
  EXPECT_EQ(first.body.vertices, second.body.vertices);
  EXPECT_EQ(first.body.triangles, second.body.triangles);
  EXPECT_EQ(first.report.actions, second.report.actions);
}

}  // namespace
}  // namespace carillon::solvers
