// Bodies of several parts, and meshes with a wrong element.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "../solvers/closed_forms.hpp"
#include "../solvers/test_meshes.hpp"
#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "hard_case.hpp"
#include "solvers/mesh/raise_order.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon {
namespace {

using namespace solvers;
using namespace test;

/// Elements of some regions of a mesh, as one region.
TetMesh part_of(const TetMesh& mesh, const std::vector<int>& regions) {
  TetMesh out = mesh;
  out.elements.clear();
  out.regions.clear();
  out.region_names = {"body"};
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    if (std::count(regions.begin(), regions.end(), mesh.regions[e]) == 0) continue;
    const auto element = mesh.element(e);
    out.elements.insert(out.elements.end(), element.begin(), element.end());
    out.regions.push_back(0);
  }
  out.faces = solvers::mesh::boundary_faces(out);
  return out;
}

/// 3 x 3 x 3 cubes of 20 mm, one region each: 9 i + 3 j + k.
TetMesh cubes(int order) {
  return box_mesh(Vec3::Constant(0.06), {3, 3, 3}, order, [](const Vec3& x) {
    const auto place = [](double a) { return static_cast<int>(a / 0.02); };
    return 9 * place(x[0]) + 3 * place(x[1]) + place(x[2]);
  });
}

/// Three cubes in a row, joined by faces: one body, six rigid modes, the modes of the whole bar.
TEST(Hard, ThreeTouchingByFaces) {
  const auto row = box_mesh({0.06, 0.02, 0.02}, {3, 1, 1}, 3,
                            [](const Vec3& x) { return static_cast<int>(x[0] / 0.02); });
  const auto modes = lowest_modes(row, {steel, steel, steel}, 12);
  const auto whole = lowest_modes(box_mesh({0.06, 0.02, 0.02}, {3, 1, 1}, 3), {steel}, 12);
  expect_sound(modes);
  EXPECT_EQ(modes.certificate.components, 1);
  EXPECT_EQ(modes.certificate.rigid_modes, 6);
  ASSERT_EQ(modes.size(), whole.size());
  for (std::size_t k = 0; k < whole.size(); ++k) {
    EXPECT_NEAR(modes.frequency(k) / whole.frequency(k), 1, 1e-10);
  }
}

/// Cubes on the diagonal of a face or of the block hang together by edges and points: two hinges,
/// two ball joints, or one of each. Refused, however narrow the band.
TEST(Hard, ThreeTouchingByEdgesAndPoints) {
  struct Case {
    std::vector<int> cubes;
    int swings;
  };
  for (const int order : {1, 2, 3}) {
    const auto block = cubes(order);
    for (const auto& [places, swings] :
         {Case{{0, 12, 24}, 2}, Case{{0, 13, 26}, 6}, Case{{0, 12, 25}, 4}}) {
      const auto body = part_of(block, places);
      ASSERT_EQ(body.element_count(), 18u);
      ASSERT_EQ(solvers::mesh::count_components(body), 1);
      for (const solvers::modes::Band& band :
           {solvers::modes::Band{20, 20000, 300}, solvers::modes::Band{0, 1e6, 3}}) {
        const auto refusal = message_of<core::SolverError>([&] { modes_in(body, {steel}, band); });
        EXPECT_NE(refusal.find("hang together by a single point or edge"), std::string::npos)
            << refusal;
        const auto motions = "has " + std::to_string(swings) + " motions without strain";
        EXPECT_NE(refusal.find(motions), std::string::npos) << refusal;
      }
    }
  }
}

/// Three loose bodies of one mesh: 18 rigid modes, and the modes of all three together.
TEST(Hard, ThreeLooseComponents) {
  const auto one = box_mesh({0.02, 0.03, 0.05}, {1, 2, 3}, 3);
  const auto placed = [&](double size, double x) {
    return moved(one, [=](const Vec3& p) -> Vec3 { return size * p + Vec3(x, 0, 0); });
  };
  const auto all = joined(joined(one, placed(0.7, 0.1)), placed(1e-2, 0.2));
  const solvers::modes::Band band{20, 100000, 300};
  const auto modes = modes_in(all, {steel, glass, aluminium}, band);
  expect_sound(modes);
  expect_complete(modes);
  EXPECT_EQ(modes.certificate.components, 3);
  EXPECT_EQ(modes.certificate.rigid_modes, 18);
  auto expected = frequencies(modes_in(one, {steel}, band));
  const auto second = frequencies(modes_in(placed(0.7, 0), {glass}, band));
  EXPECT_TRUE(modes_in(placed(1e-2, 0), {aluminium}, band).eigenvalues.empty());
  expected.insert(expected.end(), second.begin(), second.end());
  std::sort(expected.begin(), expected.end());
  ASSERT_EQ(modes.size(), expected.size());
  ASSERT_GT(expected.size(), 20u);
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_NEAR(modes.frequency(k) / expected[k], 1, 1e-9) << k;
  }
}

/// Bodies that lie against each other without a common node are two bodies.
TEST(Hard, TouchingWithoutCommonNodes) {
  const auto one = box_mesh({0.02, 0.03, 0.05}, {1, 2, 3}, 2);
  const auto two =
      joined(one, moved(one, [](const Vec3& x) -> Vec3 { return x + Vec3(0.02, 0, 0); }));
  const auto modes = lowest_modes(two, {steel, steel}, 12);
  const auto single = lowest_modes(one, {steel}, 6);
  expect_sound(modes);
  EXPECT_EQ(modes.certificate.components, 2);
  ASSERT_EQ(modes.size(), 12u);
  for (std::size_t k = 0; k < 12; ++k) {
    EXPECT_NEAR(modes.frequency(k) / single.frequency(k / 2), 1, 1e-9);
  }
}

/// One element turned inside out, of any order: named, with its place.
TEST(Hard, OneInvertedElement) {
  for (int order = 1; order <= 4; ++order) {
    auto mesh = box_mesh({0.02, 0.03, 0.05}, {2, 3, 5}, order);
    const std::size_t wrong = 101;
    const auto nodes = static_cast<std::size_t>(solvers::elements::nodes_per_tetrahedron(order));
    const auto& lattice = solvers::elements::tetrahedron_lattice(order);
    const auto before = mesh;
    for (std::size_t n = 0; n < nodes; ++n) {
      auto swapped = lattice[n];
      std::swap(swapped[0], swapped[1]);
      const auto at = std::find(lattice.begin(), lattice.end(), swapped) - lattice.begin();
      mesh.elements[wrong * nodes + n] = before.element(wrong)[static_cast<std::size_t>(at)];
    }
    const auto refusal = message_of<core::SolverError>([&] { lowest_modes(mesh, {steel}, 5); });
    EXPECT_NE(refusal.find("element 101 near ("), std::string::npos) << refusal;
    EXPECT_NE(refusal.find("turned inside out or flat"), std::string::npos) << refusal;
  }
}

/// One curved element whose side is folded into it.
TEST(Hard, OneFoldedElement) {
  for (int order = 2; order <= 4; ++order) {
    auto mesh = box_mesh({0.02, 0.03, 0.05}, {2, 3, 5}, order);
    // A node on an edge goes past the element's middle.
    const auto element = mesh.element(101);
    const auto& lattice = solvers::elements::tetrahedron_lattice(order);
    std::size_t n = 0;
    while (lattice[n][0] != order - 1 || lattice[n][1] != 1) ++n;
    const auto node = [&](std::size_t i) -> Vec3& {
      return mesh.nodes[static_cast<std::size_t>(element[i])];
    };
    Vec3 middle = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i) middle += node(i) / 4;
    const Vec3 from = node(n);
    node(n) = from + 3 * (middle - from);
    const auto refusal = message_of<core::SolverError>([&] { lowest_modes(mesh, {steel}, 5); });
    EXPECT_NE(refusal.find("turned inside out or flat"), std::string::npos) << order << refusal;
  }
}

const Vec3 block_sides(0.02, 0.03, 0.05);

/// A mesh whose node was dragged through its neighbours, saved by a mesher that turns every element
/// the right way: the body would fill some place twice and weigh two per cent too much.
TEST(Hard, TangledMeshFromAFile) {
  auto tangled = box_mesh(block_sides, {2, 3, 5}, 1);
  const auto inner = std::find_if(tangled.nodes.begin(), tangled.nodes.end(), [](const Vec3& x) {
    return (x - Vec3(0.01, 0.01, 0.01)).norm() < 1e-9;
  });
  ASSERT_NE(inner, tangled.nodes.end());
  *inner += Vec3(0.013, 0, 0);
  const core::TemporaryFolder folder;
  const auto mesh =
      solvers::mesh::readers::read_msh(written(folder, "tangled.msh", msh_text(tangled)));
  EXPECT_GT(solvers::mesh::measure_quality(mesh).volume, 1.01 * block_sides.prod());
  for (int order = 1; order <= 3; ++order) {
    const auto refusal = message_of<core::SolverError>(
        [&] { lowest_modes(solvers::mesh::raise_order(mesh, order), {steel}, 5); });
    EXPECT_NE(refusal.find("overlap near ("), std::string::npos) << refusal;
  }
}

/// An element that stands twice would count its stiffness and mass twice.
TEST(Hard, DuplicateElement) {
  for (int order = 1; order <= 4; ++order) {
    auto mesh = box_mesh(block_sides, {2, 3, 5}, order);
    const auto element = mesh.element(101);
    const std::vector<std::int32_t> nodes(element.begin(), element.end());
    mesh.elements.insert(mesh.elements.end(), nodes.begin(), nodes.end());
    mesh.regions.push_back(0);
    const auto refusal = message_of<core::SolverError>([&] { lowest_modes(mesh, {steel}, 5); });
    EXPECT_NE(refusal.find("elements 101 and 180 overlap"), std::string::npos) << refusal;
  }
}

/// In a file an element of two physical groups stands twice: it counts once, in its first group.
TEST(Hard, DuplicateElementInAFile) {
  auto mesh = box_mesh(block_sides, {2, 3, 5}, 1);
  for (std::size_t i = 0; i < 4; ++i) mesh.elements.push_back(mesh.elements[4 * 101 + i]);
  mesh.regions.push_back(0);
  const core::TemporaryFolder folder;
  const auto read = solvers::mesh::readers::read_msh(written(folder, "twice.msh", msh_text(mesh)));
  EXPECT_EQ(read.element_count(), 180u);
  const auto modes = lowest_modes(read, {steel}, 5);
  const auto truth = lowest_modes(box_mesh(block_sides, {2, 3, 5}, 1), {steel}, 5);
  EXPECT_NEAR(modes.frequency(0) / truth.frequency(0), 1, 1e-10);
}

/// A fine half on a coarse one, joined where corners coincide.
TetMesh unmatched_halves(double gap) {
  const auto coarse = box_mesh({0.02, 0.03, 0.025}, {2, 3, 2}, 1);
  const auto fine = moved(box_mesh({0.02, 0.03, 0.025}, {4, 6, 4}, 1),
                          [gap](const Vec3& x) -> Vec3 { return x + Vec3(0, 0, 0.025 + gap); });
  auto both = joined(coarse, fine);
  std::vector<std::int32_t> first(both.nodes.size());
  for (std::size_t n = 0; n < both.nodes.size(); ++n) {
    const auto same = std::find_if(both.nodes.begin(), both.nodes.end(), [&](const Vec3& x) {
      return (x - both.nodes[n]).norm() < 1e-9;
    });
    first[n] = static_cast<std::int32_t>(same - both.nodes.begin());
  }
  for (auto& n : both.elements) n = first[static_cast<std::size_t>(n)];
  both.region_names = {"body"};
  std::fill(both.regions.begin(), both.regions.end(), 0);
  both.faces = solvers::mesh::boundary_faces(both);
  return both;
}

/// Elements of two finenesses that meet without matching: the body would be torn open between the
/// common corners and sound tones too low. Refused with the place; parted halves are two bodies.
TEST(Hard, HangingNodesInAFile) {
  const auto halves = unmatched_halves(0);
  ASSERT_EQ(solvers::mesh::count_components(halves), 1);
  const auto torn = lowest_modes(with_order(halves, 2), {steel}, 1);
  const auto whole = lowest_modes(box_mesh(block_sides, {2, 3, 4}, 2), {steel}, 1);
  // Half an octave too low, were it solved.
  EXPECT_LT(cents(torn.frequency(0), whole.frequency(0)), -400);
  const core::TemporaryFolder folder;
  for (int order = 1; order <= 2; ++order) {
    const auto refusal = message_of<core::InputError>([&] {
      solvers::mesh::readers::read_msh(
          written(folder, "torn.msh", msh_text(with_order(halves, order))));
    });
    EXPECT_NE(refusal.find("0.025) lies inside a face of tetrahedron"), std::string::npos)
        << refusal;
  }
  const auto parted = solvers::mesh::readers::read_msh(
      written(folder, "parted.msh", msh_text(unmatched_halves(1e-3))));
  EXPECT_EQ(solvers::mesh::count_components(parted), 2);
}

/// Nodes that no element uses change nothing.
TEST(Hard, NodesThatNoElementUses) {
  const auto body = box_mesh(block_sides, {2, 3, 4}, 2);
  auto loose = body;
  loose.nodes.insert(loose.nodes.begin(), Vec3(0.01, 0.01, 0.01));
  for (auto& n : loose.elements) ++n;
  for (auto& n : loose.faces) ++n;
  loose.nodes.emplace_back(0.02, 0.02, 0.02);
  const auto a = lowest_modes(body, {steel}, 8), b = lowest_modes(loose, {steel}, 8);
  for (std::size_t k = 0; k < 8; ++k) EXPECT_NEAR(a.frequency(k) / b.frequency(k), 1, 1e-10);
  EXPECT_EQ(a.surface.nodes.size(), b.surface.nodes.size());
}

/// All that a single element has, rigid motions left out.
TEST(Hard, OneElement) {
  for (int order = 1; order <= 4; ++order) {
    TetMesh mesh;
    mesh.nodes = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}};
    mesh.elements = {0, 1, 2, 3};
    mesh.regions = {0};
    mesh.region_names = {"body"};
    const auto modes = lowest_modes(with_order(mesh, order), {steel}, 1000);
    expect_sound(modes);
    EXPECT_EQ(static_cast<int>(modes.size()),
              3 * solvers::elements::nodes_per_tetrahedron(order) - 6);
    EXPECT_TRUE(modes.certificate.complete);
  }
}

}  // namespace
}  // namespace carillon
