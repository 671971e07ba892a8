// Repair of meshes made by others, where they are at hand.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <random>
#include <set>

#include "solvers/mesh/readers/read_mesh.hpp"
#include "tests/solvers/repaired.hpp"

namespace carillon::solvers {
namespace {

using namespace test;  // NOLINT: bodies and damages
using core::InputError;

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
    mesh::MeshFile file;
    file.path = entry.path().string();
    try {
      mesh::Diagnosis diagnosis;
      mesh::RepairReport report;
      const mesh::SurfaceMesh body =
          mesh::repair::repair(mesh::readers::read_surface(file.path), file, diagnosis, report);
      EXPECT_TRUE(mesh::repair::diagnose(body).clean);
      EXPECT_EQ(report.used_as_is, report.actions.empty());
    } catch (const InputError& error) {
      EXPECT_NE(error.message().find(file.path), std::string::npos);
      refused.insert(entry.path().filename());
    }
  }
  // Those that are no body whatever one does, two balls that touch in a point, and pieces whose
  // gaps a wrap would close.
  EXPECT_EQ(refused, (std::set<std::string>{
                         "bowl_vhacd_96_pieces.obj", "degenerate_flat.off",
                         "edge_with_four_triangles.off", "empty.stl", "hour_glass_vertex_touch.off",
                         "tetra_pierced_by_triangle.off", "triangle_soup_100.stl"}));
}

TEST(MeshesByOthers, ComeBackFromDamageWithinOnePercent) {
  const auto folder = meshes_by_others();
  if (folder.empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  std::mt19937_64 random(1);
  for (const auto& entry : std::filesystem::directory_iterator(folder / "clean")) {
    SCOPED_TRACE(entry.path().filename());
    const mesh::SurfaceMesh mesh =
        repaired(mesh::readers::read_surface(entry.path().string())).body;
    const auto check = [&mesh](const mesh::SurfaceMesh& broken, const char* damage) {
      SCOPED_TRACE(damage);
      const Outcome outcome = repaired(broken);
      EXPECT_NEAR(mesh::signed_volume(outcome.body) / mesh::signed_volume(mesh), 1, 0.01);
      EXPECT_FALSE(says(outcome.report, "wrap"));
    };
    const mesh::SurfaceMesh dropped = damaged(mesh, Damage::dropped, 0.01, random);
    if (mesh.triangles.size() < 20000) {
      check(dropped, "dropped");
      check(damaged(mesh, Damage::flipped, 0.01, random), "flipped");
      check(damaged(mesh, Damage::doubled, 0.01, random), "doubled");
      check(damaged(mesh, Damage::seams, 0.01, random), "seams");
    }
    const mesh::SurfaceMesh flipped = damaged(dropped, Damage::flipped, 0.01, random);
    const mesh::SurfaceMesh doubled = damaged(flipped, Damage::doubled, 0.01, random);
    check(damaged(doubled, Damage::seams, 0.01, random), "everything");
  }
}

}  // namespace
}  // namespace carillon::solvers
