// Estimated against true pitch errors of every reference body, as a table.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "reference_bodies.hpp"
#include "test_meshes.hpp"

namespace carillon {
namespace {

class Sweep : public testing::TestWithParam<test::ReferenceBody> {};

TEST_P(Sweep, EstimatesAreTrue) {
  if (test::data_folder().empty()) GTEST_SKIP() << "CARILLON_TEST_DATA is not set";
  const auto& body = GetParam();
  const auto truth = test::table_frequencies(body.table);
  const auto wanted = std::min<std::size_t>(truth.size(), 40);
  for (int order = 1; order <= 4; ++order) {
    std::size_t compared = 0;
    for (int size = 0; size < 3; ++size) {
      core::Trace trace;
      solvers::eigen::SolveOptions options;
      options.band = {0, 1e9, static_cast<int>(2 * wanted)};
      const auto mesh = body.mesh(order, size);
      const auto modes = solvers::eigen::solve_modes(mesh, std::vector{body.material}, options,
                                                     MPI_COMM_SELF, trace);
      const auto found = test::measure_effectivity(modes, std::span(truth).first(wanted));
      fmt::print(
          "{:22} order {} size {}: {:6} unknowns, worst {:9.3f} cents, {:2} modes, "
          "effectivity {:5.2f} {:5.2f} {:5.2f}; solve {:.2f} s, estimate {:.2f} s\n",
          body.name, order, size, modes.certificate.unknowns, found.worst_error, found.compared,
          found.minimum, found.median, found.maximum,
          trace.stages["solve"].seconds + trace.stages["count"].seconds,
          trace.stages["estimate"].seconds);
      std::fflush(stdout);
      EXPECT_EQ(found.complaint, "") << body.name << ", order " << order << ", size " << size;
      compared += found.compared;
    }
    EXPECT_GT(compared, 0u) << body.name << ", order " << order;
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, Sweep, testing::ValuesIn(test::reference_bodies()),
                         [](const auto& body) {
                           std::string name = body.param.name;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

}  // namespace
}  // namespace carillon
