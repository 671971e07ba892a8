// Diagnosis and repair: bodies whose volume is known, damaged in known ways; then meshes by others.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "core/error.hpp"
#include "solvers/read_mesh.hpp"
#include "solvers/repair.hpp"
#include "tests/solvers/temporary_folder.hpp"
#include "tests/solvers/test_surfaces.hpp"

namespace carillon::solvers {
namespace {

using namespace test;  // NOLINT: bodies and damages
using core::InputError;

struct Outcome {
  SurfaceMesh body;
  Diagnosis diagnosis;
  RepairReport report;
};

Outcome repaired(const SurfaceMesh& mesh, double thickness = 0) {
  MeshFile file;
  file.path = "body.obj";
  file.thickness = thickness;
  Outcome outcome;
  outcome.body = repair(mesh, file, outcome.diagnosis, outcome.report);
  EXPECT_TRUE(diagnose(outcome.body).clean);
  return outcome;
}

std::string refusal(const SurfaceMesh& mesh) {
  return message_of<InputError>([&mesh] { repaired(mesh); });
}

bool says(const RepairReport& report, const std::string& word) {
  for (const std::string& action : report.actions) {
    if (action.find(word) != std::string::npos) return true;
  }
  return false;
}

struct Body {
  const char* name;
  SurfaceMesh mesh;
};

std::vector<Body> bodies() {
  return {{"sphere", sphere_surface(0.05, 10)},
          {"box", box_surface(Vec3(0.02, 0.03, 0.05), 6)},
          {"torus", torus_surface(0.04, 0.015, 14)},
          {"tube", tube_surface(0.02, 0.003, 0.1, 10)},
          {"bowl", bowl_surface(0.07, 0.004, 10)}};
}

TEST(Diagnose, FindsNothingWrongWithCleanBodies) {
  for (const Body& body : bodies()) {
    SCOPED_TRACE(body.name);
    const Diagnosis d = diagnose(body.mesh);
    EXPECT_TRUE(d.clean);
    EXPECT_TRUE(d.closed);
    EXPECT_EQ(d.components, 1);
    EXPECT_GT(d.volume, 0);
  }
  const Diagnosis box = diagnose(box_surface(Vec3(1, 2, 3), 2));
  EXPECT_NEAR(box.volume, 6, 1e-14);
  EXPECT_NEAR(box.area, 22, 1e-13);
  EXPECT_EQ(box.extent, (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(box.vertices, 26);
  EXPECT_EQ(box.triangles, 48);
}

TEST(Diagnose, CountsEveryDefect) {
  SurfaceMesh mesh = box_surface(Vec3(1, 1, 1), 2);
  mesh.triangles.push_back(mesh.triangles[3]);  // a twin: three new edges of 3
  mesh.vertices.push_back(mesh.vertices[0]);    // a duplicate nobody uses
  mesh.triangles.push_back({mesh.triangles[0][0], mesh.triangles[0][0], mesh.triangles[0][1]});
  Diagnosis d = diagnose(mesh);
  EXPECT_EQ(d.duplicate_triangles, 1);
  EXPECT_EQ(d.duplicate_vertices, 1);
  EXPECT_EQ(d.unreferenced_vertices, 1);
  EXPECT_EQ(d.degenerate_triangles, 1);
  EXPECT_GE(d.nonmanifold_edges, 3);
  EXPECT_FALSE(d.clean);

  mesh = box_surface(Vec3(1, 1, 1), 2);
  std::swap(mesh.triangles[5][0], mesh.triangles[5][1]);
  EXPECT_EQ(diagnose(mesh).misoriented_edges, 3);
  mesh.triangles.erase(mesh.triangles.begin() + 5);
  EXPECT_EQ(diagnose(mesh).boundary_edges, 3);
  EXPECT_FALSE(diagnose(mesh).closed);

  const SurfaceMesh sphere = sphere_surface(1, 6);
  d = diagnose(together(sphere, moved(sphere, Vec3(1, 0, 0))));
  EXPECT_EQ(d.components, 2);
  EXPECT_EQ(d.touching_components, 2);
  EXPECT_GT(d.self_intersections, 10);
  d = diagnose(together(sphere, turned_over(sphere_surface(0.5, 4))));
  EXPECT_EQ(d.nested_components, 1);
  EXPECT_TRUE(d.clean);  // a hollow ball
  EXPECT_FALSE(diagnose(together(sphere, sphere_surface(0.5, 4))).clean);
  EXPECT_FALSE(diagnose(turned_over(sphere)).clean);
}

TEST(Diagnose, FindsVerticesWhereSurfacesOnlyTouch) {
  const SurfaceMesh box = box_surface(Vec3(1, 1, 1), 1);
  SurfaceMesh mesh = together(box, moved(box, Vec3(1, 1, 1)));
  // Join the corners that meet.
  std::int32_t corner = -1;
  for (std::size_t v = 0; v < 8; ++v) {
    if (mesh.vertices[v] == Vec3(1, 1, 1)) corner = static_cast<std::int32_t>(v);
  }
  for (Triangle& t : mesh.triangles) {
    for (std::int32_t& v : t) {
      if (mesh.vertices[static_cast<std::size_t>(v)] == Vec3(1, 1, 1)) v = corner;
    }
  }
  const Diagnosis d = diagnose(mesh);
  EXPECT_EQ(d.nonmanifold_vertices, 1);
  EXPECT_EQ(d.nonmanifold_edges, 0);
  EXPECT_EQ(d.touching_components, 2);
}

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
    SurfaceMesh mesh = body.mesh;
    // Each kind of damage once or not at all, in any order.
    std::vector<Damage> damages{Damage::dropped, Damage::flipped, Damage::doubled, Damage::seams};
    std::shuffle(damages.begin(), damages.end(), random);
    damages.resize(*rc::gen::inRange<std::size_t>(1, 5));
    for (const Damage damage : damages) mesh = damaged(mesh, damage, 0.01, random);
    const Outcome outcome = repaired(mesh);
    const double change = signed_volume(outcome.body) / signed_volume(body.mesh) - 1;
    RC_CLASSIFY(says(outcome.report, "wrap"), "wrapped");
    RC_ASSERT(std::abs(change) < 0.01);
  }));
}

TEST(Repair, ClosesCracksAndDoesNotTouchTheRest) {
  SurfaceMesh mesh = sphere_surface(0.05, 8);
  std::mt19937_64 random(3);
  mesh = damaged(mesh, Damage::seams, 0.2, random);
  for (std::size_t v = mesh.vertices.size() - 50; v < mesh.vertices.size(); ++v) {
    mesh.vertices[v] += Vec3(2e-8, -1e-8, 1e-8);
  }
  const Outcome outcome = repaired(mesh);
  EXPECT_NEAR(signed_volume(outcome.body), signed_volume(sphere_surface(0.05, 8)), 1e-10);
  EXPECT_FALSE(says(outcome.report, "wrap"));
  EXPECT_EQ(outcome.body.vertices.size(), sphere_surface(0.05, 8).vertices.size());
}

TEST(Repair, TurnsInsideOutBodiesAndKeepsCavities) {
  const SurfaceMesh outer = sphere_surface(0.05, 8);
  const SurfaceMesh inner = sphere_surface(0.03, 6);
  const double solid = signed_volume(outer);
  EXPECT_EQ(signed_volume(repaired(turned_over(outer)).body), solid);
  // A hollow ball whose skins both look the wrong way.
  const Outcome hollow = repaired(together(turned_over(outer), inner));
  EXPECT_NEAR(signed_volume(hollow.body), solid - signed_volume(inner), 1e-12);
  // Skins that look the same way: the inner body lies in material that is there already.
  const Outcome swallowed = repaired(together(outer, inner));
  EXPECT_NEAR(signed_volume(swallowed.body), solid, 1e-12);
  EXPECT_TRUE(says(swallowed.report, "inside the material"));
}

TEST(Repair, UnitesBodiesThatMeet) {
  const SurfaceMesh box = box_surface(Vec3(1, 1, 1), 2);
  const Outcome overlap = repaired(together(box, moved(box, Vec3(0.5, 0.25, 0.3))));
  EXPECT_NEAR(signed_volume(overlap.body), 2 - 0.5 * 0.75 * 0.7, 1e-9);
  EXPECT_TRUE(says(overlap.report, "united"));
  // Face on face, with edges that do not fit.
  const Outcome stacked = repaired(together(box, moved(box, Vec3(1, 0.25, 0.3))));
  EXPECT_NEAR(signed_volume(stacked.body), 2, 1e-9);
  EXPECT_EQ(diagnose(stacked.body).components, 1);
}

TEST(Repair, KeepsSeparatePiecesAndSaysSo) {
  const SurfaceMesh box = box_surface(Vec3(1, 1, 1), 2);
  const SurfaceMesh two = together(box, moved(box, Vec3(3, 0, 0)));
  EXPECT_TRUE(repaired(two).report.used_as_is);
  std::mt19937_64 random(4);
  const Outcome outcome = repaired(damaged(two, Damage::flipped, 0.05, random));
  EXPECT_NEAR(signed_volume(outcome.body), 2, 1e-12);
  EXPECT_TRUE(says(outcome.report, "2 closed surfaces"));
}

TEST(Repair, SeparatesBodiesThatShareAnEdge) {
  // Welded along an edge of four triangles; they touch, so they are joined there or not at all.
  const SurfaceMesh box = box_surface(Vec3(1, 1, 1), 2);
  const Outcome outcome = repaired(together(box, moved(box, Vec3(1, 1, 0))));
  EXPECT_NEAR(signed_volume(outcome.body), 2, 0.02);
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
  EXPECT_NEAR(signed_volume(outcome.body), 1, 1e-12);
  EXPECT_EQ(diagnose(outcome.body).components, 1);
  EXPECT_FALSE(says(outcome.report, "wrap"));
}

TEST(Repair, GivesSheetsAThickness) {
  // The outer skin of a bowl: half a sphere without a lid.
  SurfaceMesh sheet = sphere_surface(0.05, 12);
  std::erase_if(sheet.triangles, [&sheet](const Triangle& t) {
    double height = 0;
    for (const std::int32_t v : t) height += sheet.vertices[static_cast<std::size_t>(v)].z();
    return height > 0;
  });
  EXPECT_NE(refusal(sheet).find("thickness"), std::string::npos);
  const Outcome outcome = repaired(sheet, 0.003);
  EXPECT_NEAR(signed_volume(outcome.body), area(sheet) * 0.003, 0.02 * area(sheet) * 0.003);
  EXPECT_TRUE(says(outcome.report, "thickness"));

  // A flat square, and one that is folded sharply: offsets would meet inside the fold.
  SurfaceMesh flat;
  flat.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_NE(refusal(flat).find("flat"), std::string::npos);
  EXPECT_NEAR(signed_volume(repaired(flat, 0.002).body), 0.01 * 0.002, 1e-12);
  flat.vertices.emplace_back(0.002, 0.05, 0.01);
  flat.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}};
  EXPECT_GT(signed_volume(repaired(flat, 0.004).body), 0.8 * area(flat) * 0.004);
}

TEST(Repair, RefusesHeapsOfTriangles) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> place(0, 1);
  SurfaceMesh heap;
  for (int i = 0; i < 300; ++i)
    heap.vertices.emplace_back(place(random), place(random), place(random));
  for (std::int32_t i = 0; i < 300; i += 3) heap.triangles.push_back({i, i + 1, i + 2});
  EXPECT_NE(refusal(heap).find("loose"), std::string::npos);
  SurfaceMesh line;
  line.vertices = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  line.triangles = {{0, 1, 2}};
  EXPECT_NE(refusal(line).find("no area"), std::string::npos);
}

TEST(Repair, IsDeterministic) {
  std::mt19937_64 random(11);
  SurfaceMesh mesh = damaged(torus_surface(0.04, 0.015, 12), Damage::dropped, 0.03, random);
  mesh = damaged(mesh, Damage::flipped, 0.03, random);
  const Outcome first = repaired(mesh);
  const Outcome second = repaired(mesh);
  EXPECT_EQ(first.body.vertices, second.body.vertices);
  EXPECT_EQ(first.body.triangles, second.body.triangles);
  EXPECT_EQ(first.report.actions, second.report.actions);
}

/// Folder of meshes by others, or "" when it is absent.
std::filesystem::path meshes_by_others() {
  const char* data = std::getenv("CARILLON_TEST_DATA");
  if (data == nullptr || !std::filesystem::exists(std::filesystem::path(data) / "meshes"))
    return {};
  return std::filesystem::path(data) / "meshes";
}

TEST(MeshesByOthers, EndInABodyOrANamedReason) {
  const auto folder = meshes_by_others();
  if (folder.empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  std::set<std::string> refused;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().extension() == ".csv") continue;
    SCOPED_TRACE(entry.path().filename());
    MeshFile file;
    file.path = entry.path().string();
    try {
      Diagnosis diagnosis;
      RepairReport report;
      const SurfaceMesh body = repair(read_surface(file.path), file, diagnosis, report);
      EXPECT_TRUE(diagnose(body).clean);
      EXPECT_EQ(report.used_as_is, report.actions.empty());
    } catch (const InputError& error) {
      EXPECT_NE(error.message().find(file.path), std::string::npos);
      refused.insert(entry.path().filename());
    }
  }
  // Those that are no body whatever one does.
  EXPECT_EQ(refused, (std::set<std::string>{"degenerate_flat.off", "edge_with_four_triangles.off",
                                            "empty.stl", "tetra_pierced_by_triangle.off",
                                            "triangle_soup_100.stl"}));
}

TEST(MeshesByOthers, ComeBackFromDamageWithinOnePercent) {
  const auto folder = meshes_by_others();
  if (folder.empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  std::mt19937_64 random(1);
  for (const auto& entry : std::filesystem::directory_iterator(folder / "clean")) {
    SCOPED_TRACE(entry.path().filename());
    const SurfaceMesh mesh = repaired(read_surface(entry.path().string())).body;
    const auto check = [&mesh](const SurfaceMesh& broken, const char* damage) {
      SCOPED_TRACE(damage);
      const Outcome outcome = repaired(broken);
      EXPECT_NEAR(signed_volume(outcome.body) / signed_volume(mesh), 1, 0.01);
      EXPECT_FALSE(says(outcome.report, "wrap"));
    };
    const SurfaceMesh dropped = damaged(mesh, Damage::dropped, 0.01, random);
    if (mesh.triangles.size() < 20000) {
      check(dropped, "dropped");
      check(damaged(mesh, Damage::flipped, 0.01, random), "flipped");
      check(damaged(mesh, Damage::doubled, 0.01, random), "doubled");
      check(damaged(mesh, Damage::seams, 0.01, random), "seams");
    }
    const SurfaceMesh flipped = damaged(dropped, Damage::flipped, 0.01, random);
    const SurfaceMesh doubled = damaged(flipped, Damage::doubled, 0.01, random);
    check(damaged(doubled, Damage::seams, 0.01, random), "everything");
  }
}

}  // namespace
}  // namespace carillon::solvers
