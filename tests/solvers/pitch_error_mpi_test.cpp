// Run at 1, 2 and 3 ranks: a group estimates what one rank does.
#include <gtest/gtest.h>
#include <mpi.h>

#include "solve.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

TEST(PitchErrorOfAGroup, IsThatOfOneRankAndOnEveryRankTheSame) {
  const auto plate = test::box_mesh({0.1, 0.1, 0.005}, {6, 6, 1}, 3);
  const auto ball =
      test::with_finer_nodes(test::ball_mesh(0.05, 2, 2), test::ball_mesh(0.05, 2, 3));
  const auto halves = test::box_mesh({0.011, 0.013, 0.1}, {2, 2, 8}, 2,
                                     [](const Vec3& x) { return x[2] < 0.05 ? 0 : 1; });
  const auto compare = [](const solvers::mesh::TetMesh& mesh,
                          const std::vector<solvers::elements::Elastic>& of) {
    const auto alone = test::lowest_modes(mesh, of, 16, MPI_COMM_SELF).pitch_errors;
    const auto group = test::lowest_modes(mesh, of, 16, MPI_COMM_WORLD).pitch_errors;
    ASSERT_EQ(group.size(), alone.size());
    ASSERT_GE(group.size(), 11u);
    for (std::size_t k = 0; k < group.size(); ++k) {
      EXPECT_NEAR(group[k], alone[k], 0.01 * alone[k] + 0.002) << "mode " << k + 1;
    }
    auto first = group;
    MPI_Bcast(first.data(), static_cast<int>(first.size()), MPI_DOUBLE, 0, MPI_COMM_WORLD);
    EXPECT_EQ(first, group);
  };
  compare(plate, {test::glass});
  compare(ball, {test::steel});
  compare(halves, {test::steel, {2e9, 0.35, 1100}});
}

}  // namespace
}  // namespace carillon
