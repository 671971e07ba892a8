#include "hard_case.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "../solvers/closed_forms.hpp"
#include "../solvers/test_meshes.hpp"

namespace carillon::test {

using namespace solvers;

void expect_sound(const solvers::modes::Modes& modes, double residual) {
  const auto& certificate = modes.certificate;
  EXPECT_LE(certificate.max_residual, residual);
  EXPECT_LT(certificate.orthonormality, 1e-9);
  EXPECT_EQ(certificate.rigid_modes, 6 * certificate.components);
  EXPECT_TRUE(certificate.count_verified);
  EXPECT_EQ(certificate.modes_found, static_cast<std::int64_t>(modes.size()));
  EXPECT_TRUE(std::is_sorted(modes.eigenvalues.begin(), modes.eigenvalues.end()));
  EXPECT_TRUE(modes.shapes.values().allFinite());
  EXPECT_EQ(modes.shapes.modes(), static_cast<Eigen::Index>(modes.size()));
  if (modes.pitch_errors.empty()) return;
  ASSERT_EQ(modes.pitch_errors.size(), modes.size());
  for (std::size_t k = 0; k < modes.size(); ++k) {
    EXPECT_TRUE(std::isfinite(modes.pitch_errors[k]) && modes.pitch_errors[k] >= 0)
        << "mode " << k + 1 << ": " << modes.pitch_errors[k];
  }
}

void expect_complete(const solvers::modes::Modes& modes) {
  EXPECT_TRUE(modes.certificate.count_verified);
  EXPECT_TRUE(modes.certificate.complete);
  EXPECT_EQ(modes.certificate.modes_found, modes.certificate.modes_in_band);
  EXPECT_EQ(modes.certificate.complete_to_hz, modes.certificate.max_frequency);
}

solvers::modes::Modes modes_in(const TetMesh& mesh,
                               const std::vector<solvers::elements::Elastic>& regions,
                               const solvers::modes::Band& band,
                               solvers::modes::EigenSolver solver) {
  core::Trace trace;
  solvers::eigen::SolveOptions options;
  options.band = band;
  options.solver = solver;
  return solvers::eigen::solve_modes(mesh, regions, options, MPI_COMM_SELF, trace);
}

double worst_cents(const std::vector<double>& found, const std::vector<double>& truth,
                   std::size_t count) {
  EXPECT_GE(found.size(), count);
  EXPECT_GE(truth.size(), count);
  double worst = 0;
  for (std::size_t k = 0; k < std::min({count, found.size(), truth.size()}); ++k) {
    worst = std::max(worst, std::abs(cents(found[k], truth[k])));
  }
  return worst;
}

namespace {

/// A first-order mesh that grows by tetrahedra, each turned so that its volume is positive.
struct Growing {
  TetMesh mesh;

  void add(std::array<std::int32_t, 4> tetrahedron) {
    const auto p = [&](std::size_t v) {
      return mesh.nodes[static_cast<std::size_t>(tetrahedron[v])];
    };
    if ((p(1) - p(0)).cross(p(2) - p(0)).dot(p(3) - p(0)) < 0) {
      std::swap(tetrahedron[2], tetrahedron[3]);
    }
    mesh.elements.insert(mesh.elements.end(), tetrahedron.begin(), tetrahedron.end());
    mesh.regions.push_back(0);
  }
};

}  // namespace

TetMesh sliver_mesh(const Vec3& sides, const std::array<int, 3>& cells, int middle, double dihedral,
                    int order) {
  const auto [nx, ny, nz] = cells;
  const auto node = [ny_ = ny, nz_ = nz](int i, int j, int k) {
    return static_cast<std::int32_t>((i * (ny_ + 1) + j) * (nz_ + 1) + k);
  };
  const Vec3 step(sides[0] / nx, sides[1] / ny, sides[2] / nz);
  // Opposite corners of a cell of the layer differ by `twist` in height: the planes of two faces of
  // its sliver meet along each side of the cell at the angle twist / (length across).
  const double twist = std::tan(dihedral * std::numbers::pi / 180) * std::max(step[0], step[1]);
  Growing body;
  body.mesh.region_names = {"body"};
  for (int i = 0; i <= nx; ++i)
    for (int j = 0; j <= ny; ++j)
      for (int k = 0; k <= nz; ++k) {
        Vec3 at = step.cwiseProduct(Vec3(i, j, k));
        if (k == middle) at[2] -= twist * i * j;
        body.mesh.nodes.push_back(at);
      }
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k) {
        // Above the layer the walks start from the other end of the first axis.
        const bool mirrored = k >= middle;
        std::array<int, 3> axes = {0, 1, 2};
        do {
          std::array<int, 3> at = {mirrored ? i + 1 : i, j, k};
          std::array<std::int32_t, 4> tetrahedron;
          tetrahedron[0] = node(at[0], at[1], at[2]);
          for (std::size_t s = 0; s < 3; ++s) {
            const int axis = axes[s];
            at[static_cast<std::size_t>(axis)] += mirrored && axis == 0 ? -1 : 1;
            tetrahedron[s + 1] = node(at[0], at[1], at[2]);
          }
          body.add(tetrahedron);
        } while (std::next_permutation(axes.begin(), axes.end()));
        if (k == middle) {
          body.add({node(i, j, k), node(i + 1, j + 1, k), node(i + 1, j, k), node(i, j + 1, k)});
        }
      }
  return with_order(body.mesh, order);
}

TetMesh symmetric_box_mesh(const Vec3& sides, const std::array<int, 3>& cells, int order) {
  const auto [nx, ny, nz] = cells;
  const Vec3 half(sides[0] / (2 * nx), sides[1] / (2 * ny), sides[2] / (2 * nz));
  Growing body;
  body.mesh.region_names = {"body"};
  // Nodes of a grid of half cells, numbered as they are met.
  std::map<std::array<int, 3>, std::int32_t> known;
  const auto node = [&](const std::array<int, 3>& at) {
    const auto [entry, is_new] =
        known.try_emplace(at, static_cast<std::int32_t>(body.mesh.nodes.size()));
    if (is_new) body.mesh.nodes.push_back(half.cwiseProduct(Vec3(at[0], at[1], at[2])));
    return entry->second;
  };
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k) {
        const std::array<int, 3> middle = {2 * i + 1, 2 * j + 1, 2 * k + 1};
        for (std::size_t axis = 0; axis < 3; ++axis)
          for (const int side : {-1, 1}) {
            auto face = middle;
            face[axis] += side;
            const auto corner = [&](int a, int b) {
              auto at = face;
              at[(axis + 1) % 3] += a;
              at[(axis + 2) % 3] += b;
              return node(at);
            };
            const std::array<std::int32_t, 4> ring = {corner(-1, -1), corner(1, -1), corner(1, 1),
                                                      corner(-1, 1)};
            for (std::size_t e = 0; e < 4; ++e) {
              body.add({node(middle), node(face), ring[e], ring[(e + 1) % 4]});
            }
          }
      }
  return with_order(body.mesh, order);
}

std::vector<int> cluster_sizes(const std::vector<double>& ascending, double gap) {
  std::vector<int> sizes;
  for (std::size_t k = 0; k < ascending.size(); ++k) {
    if (k > 0 && ascending[k] - ascending[k - 1] <= gap * ascending[k]) {
      ++sizes.back();
    } else {
      sizes.push_back(1);
    }
  }
  return sizes;
}

std::string msh_text(const TetMesh& mesh) {
  // Gmsh's ten-node tetrahedron: corners, then middles of these edges.
  constexpr std::array<std::array<int, 4>, 10> theirs = {{{2, 0, 0, 0},
                                                          {0, 2, 0, 0},
                                                          {0, 0, 2, 0},
                                                          {0, 0, 0, 2},
                                                          {1, 1, 0, 0},
                                                          {0, 1, 1, 0},
                                                          {1, 0, 1, 0},
                                                          {1, 0, 0, 1},
                                                          {0, 0, 1, 1},
                                                          {0, 1, 0, 1}}};
  const auto& ours = solvers::elements::tetrahedron_lattice(mesh.order);
  std::vector<std::size_t> position;
  for (auto tuple : theirs) {
    if (mesh.order == 1) {
      if (std::count(tuple.begin(), tuple.end(), 2) == 0) break;
      for (int& fraction : tuple) fraction /= 2;
    }
    position.push_back(
        static_cast<std::size_t>(std::find(ours.begin(), ours.end(), tuple) - ours.begin()));
  }
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  text += fmt::format("$PhysicalNames\n{}\n", mesh.region_names.size());
  for (std::size_t r = 0; r < mesh.region_names.size(); ++r) {
    text += fmt::format("3 {} \"{}\"\n", r + 1, mesh.region_names[r]);
  }
  text += fmt::format("$EndPhysicalNames\n$Nodes\n{}\n", mesh.nodes.size());
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const auto& x = mesh.nodes[n];
    text += fmt::format("{} {:.17g} {:.17g} {:.17g}\n", n + 1, x[0], x[1], x[2]);
  }
  text += fmt::format("$EndNodes\n$Elements\n{}\n", mesh.element_count());
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const int group = mesh.regions[e] + 1;
    text += fmt::format("{} {} 2 {} {}", e + 1, mesh.order == 1 ? 4 : 11, group, group);
    for (const auto p : position) text += fmt::format(" {}", mesh.element(e)[p] + 1);
    text += '\n';
  }
  return text + "$EndElements\n";
}

}  // namespace carillon::test
