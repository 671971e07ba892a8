// Predictions of a mesh of another order and size, against meshes.
#include "solvers/pitch/pitch_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "family_shapes.hpp"
#include "test_meshes.hpp"

namespace carillon::test {
namespace {

using namespace solvers;

TEST(PitchModel, CountsUnknownsOfEveryOrderExactly) {
  for (const char* family : {"tile", "block", "tube", "bowl"}) {
    const auto shape = shape_at(find_family(family));
    const solvers::pitch::MeshSize size = solvers::pitch::size_of(mesh_of(shape, 2, 0.05).mesh);
    for (int order = 1; order <= 4; ++order) {
      // Holes aside, which Euler's formula leaves out: a tube has one.
      const double slack = std::string(family) == "tube" ? 3.0 * (order - 1) : 0;
      EXPECT_NEAR(solvers::pitch::resized(size, order, 1).unknowns(),
                  3.0 * static_cast<double>(mesh_of(shape, order, 0.05).mesh.nodes.size()), slack)
          << family << " " << order;
    }
  }
}

TEST(PitchModel, FollowsRefinement) {
  for (const char* family : {"tile", "block", "tube"}) {
    const auto shape = shape_at(find_family(family));
    const solvers::pitch::MeshSize coarse = solvers::pitch::size_of(mesh_of(shape, 3, 0.04).mesh);
    const solvers::pitch::MeshSize fine = solvers::pitch::size_of(mesh_of(shape, 3, 0.02).mesh);
    const solvers::pitch::MeshSize predicted =
        solvers::pitch::resized(coarse, 3, fine.element_size / coarse.element_size);
    EXPECT_NEAR(std::log(predicted.unknowns() / fine.unknowns()), 0, 0.5) << family;
    EXPECT_GT(solvers::pitch::relative_cost(fine), 2 * solvers::pitch::relative_cost(coarse))
        << family;
    EXPECT_GT(solvers::pitch::factor_memory(fine), 2 * solvers::pitch::factor_memory(coarse))
        << family;
  }
  // Figures of a cube 50^3 (398k unknowns, 5.3 GB) and a plate 150 x 150 x 4 (342k, 1.5 GB).
  EXPECT_NEAR(solvers::pitch::factor_memory(
                  {1, 0.02 * std::sqrt(3), 0, 398e3 / 3, 0, 0, 51 * 0.01 * std::sqrt(3)}),
              5.3e9, 0.5 * 5.3e9);
  EXPECT_NEAR(solvers::pitch::factor_memory({1, 0.02, 0, 342e3 / 3, 0, 0, 0.04}), 1.5e9, 0.1e9);
}

TEST(PitchModel, ErrorsFallWithTheRateOfTheOrder) {
  for (int p = 1; p <= 4; ++p) {
    EXPECT_NEAR(solvers::pitch::predicted_error(10, p, p, 1), 10, 1e-9);
    EXPECT_NEAR(solvers::pitch::predicted_error(10, p, p, 0.5), 10 * std::pow(0.5, 2 * p), 1e-9);
    EXPECT_LT(solvers::pitch::predicted_error(10, p, p + 1, 1), 10);
  }
}

}  // namespace
}  // namespace carillon::test
