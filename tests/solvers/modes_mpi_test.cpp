// Run at 1, 2 and 4 ranks: the group's answer is that of one rank.
#include <gtest/gtest.h>
#include <mpi.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <memory>
#include <thread>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "core/termination_blocked.hpp"
#include "mpi/interrupt.hpp"
#include "solve.hpp"
#include "solvers/assembly/assemble.hpp"
#include "solvers/assembly/partition.hpp"
#include "solvers/eigen/cached_modes.hpp"
#include "solvers/mesh/mirrored_part.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_mesh;
using test::lowest_modes;

int size_of(MPI_Comm comm) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  return size;
}

int rank_of(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

/// True on every rank when it is on all.
bool on_all_ranks(bool here) {
  int all = here ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  return all == 1;
}

struct Body {
  std::string name;
  test::TetMesh mesh;
  std::vector<solvers::elements::Elastic> regions;
};

std::vector<Body> bodies() {
  const auto plate = box_mesh({0.1, 0.1, 0.005}, {8, 8, 1}, 2);
  const auto block = box_mesh({0.02, 0.031, 0.053}, {2, 3, 4}, 3);
  const auto two = test::joined(
      block, test::moved(block, [](const Vec3& x) -> Vec3 { return 0.83 * x + Vec3(0.1, 0, 0); }));
  const auto halves = box_mesh({0.011, 0.013, 0.1}, {2, 2, 8}, 2,
                               [](const Vec3& x) { return x[2] < 0.05 ? 0 : 1; });
  const std::vector<mesh::MirrorPlane> planes = {{0, 0}, {1, 0}, {2, 0}};
  return {{"plate", plate, {test::glass}},
          {"two bodies", two, {test::steel, test::steel}},
          {"two materials", halves, {test::steel, {2e9, 0.35, 1100}}},
          {"ball", test::ball_mesh(0.05, 2, 3), {test::steel}},
          {"three planes of symmetry", mesh::unfold(block, planes), {test::steel}}};
}

TEST(Group, FindsTheFrequenciesOfOneRank) {
  for (const auto& body : bodies()) {
    SCOPED_TRACE(body.name);
    const auto alone = lowest_modes(body.mesh, body.regions, 25, MPI_COMM_SELF);
    const auto group = lowest_modes(body.mesh, body.regions, 25, MPI_COMM_WORLD);
    ASSERT_GE(group.certificate.unknowns, 1000) << "too small to be spread";
    ASSERT_EQ(group.size(), alone.size());
    for (std::size_t k = 0; k < alone.size(); ++k) {
      EXPECT_NEAR(group.frequency(k) / alone.frequency(k), 1, 1e-8);
    }
    EXPECT_EQ(group.certificate.modes_in_band, alone.certificate.modes_in_band);
    EXPECT_EQ(group.certificate.rigid_modes, alone.certificate.rigid_modes);
    EXPECT_LT(group.certificate.max_residual, 1e-8);
    EXPECT_LT(group.certificate.orthonormality, 1e-10);
    EXPECT_NEAR(group.mass / alone.mass, 1, 1e-12);
    // Sums over all modes are free of signs, and of bases inside pairs.
    EXPECT_NEAR(group.strain_fraction.sum(), alone.strain_fraction.sum(), 1e-9);
    EXPECT_NEAR(group.kinetic_fraction.col(0).sum() / alone.kinetic_fraction.col(0).sum(), 1, 1e-6);
    const auto energy = [](const solvers::modes::Modes& modes) {
      return modes.shapes.values().cast<double>().squaredNorm();
    };
    EXPECT_NEAR(energy(group) / energy(alone), 1, 1e-5);
  }
}

TEST(Group, GivesEveryRankTheSame) {
  const auto body = bodies()[0];
  const auto modes = lowest_modes(body.mesh, body.regions, 20, MPI_COMM_WORLD);
  std::vector<double> values = modes.eigenvalues;
  values.push_back(modes.shapes.values().cast<double>().sum());
  values.push_back(modes.mass);
  auto first = values;
  MPI_Bcast(first.data(), static_cast<int>(first.size()), MPI_DOUBLE, 0, MPI_COMM_WORLD);
  EXPECT_EQ(first, values);
}

/// Rows of K and M do not depend on the number of ranks, to the last bit.
TEST(Assembly, GivesEachRankTheRowsOfTheWhole) {
  const auto body = bodies()[2];
  const auto whole = solvers::assembly::assemble(
      body.mesh, body.regions, solvers::assembly::partition(body.mesh, 1), MPI_COMM_SELF);
  const auto part = solvers::assembly::assemble(
      body.mesh, body.regions, solvers::assembly::partition(body.mesh, size_of(MPI_COMM_WORLD)),
      MPI_COMM_WORLD);
  for (std::int32_t row = 0; row < part.graph.rows(); ++row) {
    const auto number = static_cast<std::size_t>(part.graph.begin + row);
    const auto node = part.partition.node[number];
    const auto other =
        static_cast<std::size_t>(whole.partition.number[static_cast<std::size_t>(node)]);
    double here = 0, there = 0;
    const auto r = static_cast<std::size_t>(row);
    for (auto i = part.graph.first[r]; i < part.graph.first[r + 1]; ++i) {
      here = std::max(here, std::abs(part.mass[static_cast<std::size_t>(i)]));
    }
    for (auto i = whole.graph.first[other]; i < whole.graph.first[other + 1]; ++i) {
      there = std::max(there, std::abs(whole.mass[static_cast<std::size_t>(i)]));
    }
    EXPECT_EQ(here, there);
    double stiff_here = 0, stiff_there = 0;
    for (auto i = 9 * part.graph.first[r]; i < 9 * part.graph.first[r + 1]; ++i) {
      stiff_here = std::max(stiff_here, part.stiffness[static_cast<std::size_t>(i)]);
    }
    for (auto i = 9 * whole.graph.first[other]; i < 9 * whole.graph.first[other + 1]; ++i) {
      stiff_there = std::max(stiff_there, whole.stiffness[static_cast<std::size_t>(i)]);
    }
    EXPECT_EQ(stiff_here, stiff_there);
  }
}

TEST(Partition, SharesTheNodesEvenly) {
  const auto mesh = box_mesh({0.1, 0.1, 0.02}, {10, 10, 2}, 2);
  for (int parts = 1; parts <= 5; ++parts) {
    const auto split = solvers::assembly::partition(mesh, parts);
    ASSERT_EQ(split.node_count(), static_cast<std::int32_t>(mesh.nodes.size()));
    std::vector<int> seen(mesh.nodes.size(), 0);
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
      ++seen[static_cast<std::size_t>(split.number[n])];
      EXPECT_EQ(split.node[static_cast<std::size_t>(split.number[n])], static_cast<int>(n));
    }
    EXPECT_EQ(*std::min_element(seen.begin(), seen.end()), 1);
    for (int r = 0; r < parts; ++r) {
      EXPECT_NEAR(split.owned(r) * parts / static_cast<double>(mesh.nodes.size()), 1, 0.2);
    }
  }
}

/// METIS takes SIGTERM for a fault of its own, and leaves its handler for one signal only.
TEST(Partition, SignalsThatComeWhileMetisWorksAreHeard) {
  const auto mesh = box_mesh({0.1, 0.1, 0.1}, {14, 14, 14}, 2);
  const auto split = solvers::assembly::partition(mesh, 1);
  const auto graph =
      solvers::assembly::node_graph(mesh, split, solvers::assembly::elements_around_nodes(mesh), 0);
  const auto order = solvers::assembly::nested_dissection(graph);
  for (const int delay_ms : {0, 10, 30, 90}) {
    const mpi::InterruptGuard guard;
    std::thread sender;
    {
      const core::TerminationBlocked blocked;
      sender = std::thread([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
        kill(getpid(), SIGTERM);
        kill(getpid(), SIGTERM);
      });
    }
    const auto again = solvers::assembly::nested_dissection(graph);
    sender.join();
    EXPECT_TRUE(mpi::interrupt_requested()) << delay_ms << " ms";
    EXPECT_EQ(again, order) << delay_ms << " ms";
  }
}

TEST(Group, SmallBodiesAreSolvedByEachRankAlone) {
  const auto mesh = box_mesh({0.02, 0.03, 0.05}, {1, 1, 1}, 1);
  const auto group = lowest_modes(mesh, {test::steel}, 18, MPI_COMM_WORLD);
  EXPECT_EQ(group.eigenvalues, lowest_modes(mesh, {test::steel}, 18, MPI_COMM_SELF).eigenvalues);
}

/// An element that one rank alone sees: every rank must hear of it.
TEST(Group, AgreesOnAnErrorOfOneRank) {
  auto mesh = bodies()[0].mesh;
  const auto nodes = static_cast<std::size_t>(solvers::elements::nodes_per_tetrahedron(mesh.order));
  std::swap(mesh.elements[37 * nodes], mesh.elements[37 * nodes + 1]);
  std::string message;
  try {
    lowest_modes(mesh, {test::glass}, 5, MPI_COMM_WORLD);
  } catch (const core::SolverError& e) {
    message = e.what();
  }
  EXPECT_TRUE(on_all_ranks(message.find("element 37") != std::string::npos)) << message;
  // And the group still works.
  EXPECT_EQ(lowest_modes(bodies()[0].mesh, {test::glass}, 5, MPI_COMM_WORLD).size(), 5u);
}

/// Ranks work on different bodies at the same time, while another thread of each passes messages.
TEST(Ranks, SolveTheirOwnBodiesWhileAThreadTalks) {
  MPI_Comm talk;
  MPI_Comm_dup(MPI_COMM_WORLD, &talk);
  const int rank = rank_of(MPI_COMM_WORLD), size = size_of(MPI_COMM_WORLD);
  std::thread helper([&] {
    for (int i = 0; i < 200; ++i) {
      int token = i, got = -1;
      MPI_Sendrecv(&token, 1, MPI_INT, (rank + 1) % size, 5, &got, 1, MPI_INT,
                   (rank + size - 1) % size, 5, talk, MPI_STATUS_IGNORE);
      EXPECT_EQ(got, i);
    }
  });
  const double scale = 1 + 0.1 * rank;
  const auto mesh = box_mesh(scale * Vec3(0.02, 0.031, 0.053), {2, 3, 4}, 2);
  const auto base = box_mesh({0.02, 0.031, 0.053}, {2, 3, 4}, 2);
  const auto mine = lowest_modes(mesh, {test::steel}, 8);
  helper.join();
  const auto expected = lowest_modes(base, {test::steel}, 8);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_NEAR(mine.frequency(k) * scale / expected.frequency(k), 1, 1e-10);
  }
  MPI_Comm_free(&talk);
}

TEST(Cache, IsReadByOneRankAndKnownToAll) {
  // One folder for all, named by rank 0.
  std::unique_ptr<core::TemporaryFolder> folder;
  char name[256] = {};
  if (rank_of(MPI_COMM_WORLD) == 0) {
    folder = std::make_unique<core::TemporaryFolder>();
    const auto text = folder->path().string();
    std::copy_n(text.begin(), std::min<std::size_t>(text.size(), 255), name);
  }
  MPI_Bcast(name, 256, MPI_CHAR, 0, MPI_COMM_WORLD);
  const auto body = bodies()[2];
  core::Trace trace;
  solvers::eigen::SolveOptions options;
  const auto solve = [&] {
    return solvers::eigen::cached_modes(body.mesh, body.regions, options, MPI_COMM_WORLD, name,
                                        trace);
  };
  const auto first = solve();
  const auto second = solve();
  EXPECT_EQ(trace.stages["modes from cache"].calls, 1);
  EXPECT_EQ(first.eigenvalues, second.eigenvalues);
  EXPECT_TRUE(first.shapes.values() == second.shapes.values());
  EXPECT_EQ(first.surface.faces, second.surface.faces);
  EXPECT_EQ(first.surface.nodes, second.surface.nodes);
  MPI_Barrier(MPI_COMM_WORLD);
}

}  // namespace
}  // namespace carillon
