// Reader of Gmsh's MSH files against files written by Gmsh's own library.
#include <fmt/core.h>
#include <gmsh.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <random>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"
#include "solvers/elements/lagrange.hpp"
#include "solvers/mesh/readers/detail/msh_elements.hpp"
#include "solvers/mesh/readers/detail/msh_file.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon::solvers {
namespace {

using core::InputError;
using test::message_of;

/// Gmsh's library, silent, for one test.
class MshReader : public ::testing::Test {
 protected:
  MshReader() {
    gmsh::initialize();
    gmsh::option::setNumber("General.Terminal", 0);
  }
  ~MshReader() override { gmsh::finalize(); }

  /// A block of 2 x 1 x 1 cut into two unit cubes of two groups, and a file of it.
  std::string write_block(double version, bool binary, int order, bool groups = true) {
    gmsh::clear();
    gmsh::model::occ::addBox(0, 0, 0, 1, 1, 1, 1);
    gmsh::model::occ::addBox(1, 0, 0, 1, 1, 1, 2);
    gmsh::vectorpair pieces;
    std::vector<gmsh::vectorpair> map;
    gmsh::model::occ::fragment({{3, 1}}, {{3, 2}}, pieces, map);
    gmsh::model::occ::synchronize();
    if (groups) {
      gmsh::model::addPhysicalGroup(3, {pieces[0].second}, 7);
      gmsh::model::setPhysicalName(3, 7, "oak, left");
      gmsh::model::addPhysicalGroup(3, {pieces[1].second}, 3);
      gmsh::model::addPhysicalGroup(2, {1}, 5);
      gmsh::model::setPhysicalName(2, 5, "skin");
    }
    gmsh::option::setNumber("Mesh.MeshSizeMin", 0.7);
    gmsh::option::setNumber("Mesh.MeshSizeMax", 0.7);
    gmsh::model::mesh::generate(3);
    gmsh::model::mesh::setOrder(order);
    return write(version, binary);
  }

  std::string write(double version, bool binary) {
    gmsh::option::setNumber("Mesh.MshFileVersion", version);
    gmsh::option::setNumber("Mesh.Binary", binary ? 1 : 0);
    const std::string path = (folder_.path() / "block.msh").string();
    gmsh::write(path);
    return path;
  }

  core::TemporaryFolder folder_;
};

double volume_of(const mesh::TetMesh& mesh, int region) {
  double volume = 0;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    if (mesh.regions[e] != region) continue;
    const auto element = mesh.element(e);
    const auto p = [&](std::size_t i) { return mesh.nodes[static_cast<std::size_t>(element[i])]; };
    volume += (p(1) - p(0)).cross(p(2) - p(0)).dot(p(3) - p(0)) / 6;
  }
  return volume;
}

TEST_F(MshReader, GivesNodesTheirPlacesInEveryVersionAndOrder) {
  for (const auto& [version, parametric] :
       {std::pair(2.2, 0), {2.2, 1}, {4.0, 0}, {4.0, 1}, {4.1, 0}, {4.1, 1}}) {
    gmsh::option::setNumber("Mesh.SaveParametric", parametric);
    for (const bool binary : {false, true}) {
      if (version == 4.0 && binary) continue;  // written by no Gmsh of today, and not read
      for (int order = 1; order <= 4; ++order) {
        SCOPED_TRACE(testing::Message() << version << (parametric ? " parametric" : "")
                                        << (binary ? " binary" : " text") << order);
        const mesh::TetMesh mesh = mesh::readers::read_msh(write_block(version, binary, order));
        ASSERT_EQ(mesh.order, order);
        EXPECT_EQ(mesh.region_names, (std::vector<std::string>{"group_3", "oak, left"}));
        EXPECT_NEAR(volume_of(mesh, 0), 1, 1e-12);
        EXPECT_NEAR(volume_of(mesh, 1), 1, 1e-12);
        // Straight elements: every node lies where the lattice says.
        const auto& lattice = elements::tetrahedron_lattice(order);
        for (std::size_t e = 0; e < mesh.element_count(); ++e) {
          const auto element = mesh.element(e);
          for (std::size_t i = 0; i < lattice.size(); ++i) {
            Vec3 expected = Vec3::Zero();
            for (std::size_t k = 0; k < 4; ++k) {
              expected += mesh.nodes[static_cast<std::size_t>(element[k])] * lattice[i][k] / order;
            }
            ASSERT_LT((mesh.nodes[static_cast<std::size_t>(element[i])] - expected).norm(), 1e-12);
          }
        }
        // Four sides of area 2, two of area 1; Gmsh's own count of nodes.
        mesh::SurfaceMesh surface{mesh.nodes, {}};
        const auto per_face = static_cast<std::size_t>(elements::nodes_per_face(order));
        for (std::size_t f = 0; f < mesh.face_count(); ++f) {
          surface.triangles.push_back({mesh.faces[f * per_face], mesh.faces[f * per_face + 1],
                                       mesh.faces[f * per_face + 2]});
        }
        EXPECT_NEAR(mesh::area(surface), 10, 1e-12);
        EXPECT_NEAR(mesh::signed_volume(surface), 2, 1e-12);
        std::vector<std::size_t> tags;
        std::vector<double> coordinates, parameters;
        gmsh::model::mesh::getNodes(tags, coordinates, parameters);
        EXPECT_EQ(mesh.nodes.size(), tags.size());
      }
    }
  }
}

TEST_F(MshReader, KnowsGmshsNodeOrder) {
  for (const auto& [type, order] : {std::pair{4, 1}, {11, 2}, {29, 3}, {30, 4}}) {
    std::string name;
    int dimension = 0, their_order = 0, nodes = 0, primary = 0;
    std::vector<double> uvw;
    gmsh::model::mesh::getElementProperties(type, name, dimension, their_order, nodes, uvw,
                                            primary);
    ASSERT_EQ(their_order, order);
    const auto lattice = mesh::readers::gmsh_tetrahedron_lattice(order);
    ASSERT_EQ(lattice.size(), static_cast<std::size_t>(nodes));
    for (std::size_t i = 0; i < lattice.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(uvw[3 * i + k], lattice[i][k + 1] / static_cast<double>(order), 1e-12) << i;
      }
    }
  }
}

TEST_F(MshReader, ReadsCurvedElements) {
  gmsh::model::occ::addSphere(0, 0, 0, 1);
  gmsh::model::occ::synchronize();
  gmsh::option::setNumber("Mesh.MeshSizeMax", 0.5);
  gmsh::option::setNumber("Mesh.HighOrderOptimize", 2);
  gmsh::model::mesh::generate(3);
  gmsh::model::mesh::setOrder(2);
  const mesh::TetMesh mesh = mesh::readers::read_msh(write(4.1, true));
  EXPECT_EQ(mesh.region_names, std::vector<std::string>{"body"});
  for (const std::int32_t node : mesh.faces) {
    EXPECT_NEAR(mesh.nodes[static_cast<std::size_t>(node)].norm(), 1, 1e-6);
  }
}

TEST_F(MshReader, RefusesSurfacesAndOldVersions) {
  gmsh::model::occ::addBox(0, 0, 0, 1, 1, 1);
  gmsh::model::occ::synchronize();
  gmsh::model::mesh::generate(2);
  EXPECT_NE(message_of<InputError>([&] {
              mesh::readers::read_msh(write(2.2, true));
            }).find("no tetrahedra"),
            std::string::npos);
  EXPECT_NE(message_of<InputError>([&] {
              mesh::readers::read_msh(write(1, false));
            }).find("version 1 is not read"),
            std::string::npos);
}

const std::string two_tets =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Comments\nany $text\n$EndComments\n"
    "$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n9 0 0 1\n5 9 9 9\n6 1 1 1\n$EndNodes\n"
    "$Elements\n4\n1 15 2 0 1 1\n2 4 2 0 1 1 2 3 9\n3 4 2 0 1 2 3 9 6\n4 4 2 8 1 3 2 1 9\n"
    "$EndElements\n";

TEST(ReadMsh, TurnsInvertedElementsAndDropsTwinsAndUnusedNodes) {
  const core::TemporaryFolder folder;
  const mesh::TetMesh mesh = mesh::readers::read_msh(test::written(folder, "two.msh", two_tets));
  EXPECT_EQ(mesh.element_count(), 2u);
  EXPECT_EQ(mesh.nodes.size(), 5u);
  EXPECT_NEAR(volume_of(mesh, 0), 1.0 / 6 + 1.0 / 3, 1e-15);
}

TEST(ReadMsh, RefusesOtherVolumeElementsAndMixedOrders) {
  const auto error = [](const std::string& element) {
    const core::TemporaryFolder folder;
    std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n";
    for (int i = 1; i <= 10; ++i) text += fmt::format("{} {} {} {}\n", i, i % 2, i / 2 % 2, i / 4);
    text += "$EndNodes\n$Elements\n2\n1 4 2 0 1 1 2 3 4\n" + element + "\n$EndElements\n";
    const std::string path = test::written(folder, "mixed.msh", text);
    return message_of<InputError>([&] { mesh::readers::read_msh(path); });
  };
  EXPECT_NE(error("2 5 2 0 1 1 2 3 4 5 6 7 8").find("hexahedron"), std::string::npos);
  EXPECT_NE(error("2 31 2 0 1 1 2 3 4 5 6 7 8").find("56-node"), std::string::npos);
  EXPECT_NE(error("2 11 2 0 1 1 2 3 4 5 6 7 8 9 10").find("several orders"), std::string::npos);
}

TEST(ReadMsh, NamesTheLineOfWhatIsWrong) {
  const auto error = [](const std::string& from, const std::string& to) {
    const core::TemporaryFolder folder;
    std::string text = two_tets;
    text.replace(text.find(from), from.size(), to);
    const std::string path = test::written(folder, "two.msh", text);
    return message_of<InputError>([&] { mesh::readers::read_msh(path); });
  };
  EXPECT_NE(error("1 2 3 9", "1 2 3 7").find("node 7"), std::string::npos);
  EXPECT_NE(error("2 4 2 0", "2 77 2 0").find("two.msh:19: unknown element type 77"),
            std::string::npos);
  EXPECT_NE(error("9 0 0 1", "9 0 0 inf").find("not finite"), std::string::npos);
  EXPECT_NE(error("9 0 0 1", "9 0 0 1e60").find("too large to measure"), std::string::npos);
  EXPECT_NE(error("9 0 0 1", "9 0 0 0").find("no volume"), std::string::npos);
  EXPECT_NE(error("9 0 0 1", "3 0 0 1").find("node 3 twice"), std::string::npos);
  EXPECT_NE(error("1 2 3 9", "1 2 2 9").find("uses a node twice"), std::string::npos);
  EXPECT_NE(error("$Nodes\n6", "$Nodes\n6000000000").find("can hold"), std::string::npos);
  EXPECT_NE(error("$EndNodes", "$EndMode").find("$EndNodes expected"), std::string::npos);
}

// Faces were looked at in cubes of their mean edge, of which the largest face had 1e26.
TEST(ReadMsh, OneElementMayBeFarLargerThanTheOthers) {
  const core::TemporaryFolder folder;
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n404\n", elements;
  for (int i = 0; i < 101; ++i) {
    const double size = i == 0 ? 1e15 : 1e-3;
    const double at = i == 0 ? 0 : -i;
    const int n = 4 * i;
    text += fmt::format("{} {} 0 0\n{} {} 0 0\n{} {} {} 0\n{} {} 0 {}\n", n + 1, at, n + 2,
                        at + size, n + 3, at, size, n + 4, at, size);
    elements += fmt::format("{} 4 2 0 1 {} {} {} {}\n", i + 1, n + 1, n + 2, n + 3, n + 4);
  }
  text += "$EndNodes\n$Elements\n101\n" + elements + "$EndElements\n";
  EXPECT_EQ(mesh::readers::read_msh(test::written(folder, "large.msh", text)).element_count(),
            101u);
}

TEST_F(MshReader, AnswersDamagedFilesWithAMessage) {
  for (const double version : {2.2, 4.1}) {
    for (const bool binary : {false, true}) {
      const std::string whole = core::read_file(write_block(version, binary, 2));
      std::mt19937_64 random(17);
      for (int i = 0; i < 1500; ++i) {
        try {
          const mesh::readers::MshFile file =
              mesh::readers::parse_msh("mesh", test::damaged(whole, random));
          for (const std::int32_t node : file.tetrahedra) {
            ASSERT_TRUE(node >= 0 && static_cast<std::size_t>(node) < file.nodes.size());
          }
        } catch (const InputError& error) {
          ASSERT_FALSE(error.message().empty());
        }
      }
    }
  }
}

}  // namespace
}  // namespace carillon::solvers
