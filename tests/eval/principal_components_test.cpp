// Principal components: against planted directions, by orthogonality, and whichever side is
// shorter.
#include "eval/statistics/principal_components.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::eval {
namespace {

std::vector<double> drawn(std::size_t count, std::uint64_t seed) {
  core::RandomStream random(seed, 0, "components");
  std::vector<double> values(count);
  for (double& value : values) value = random.normal();
  return values;
}

TEST(PrincipalComponents, AreThePlantedDirections) {
  // 3 u + small v around a mean, in five columns.
  const double u[] = {0.6, 0, 0.8, 0, 0}, v[] = {0, 1, 0, 0, 0};
  const std::vector<double> a = drawn(400, 1), b = drawn(400, 2);
  std::vector<double> rows;
  for (std::size_t i = 0; i < 400; ++i) {
    for (std::size_t c = 0; c < 5; ++c) rows.push_back(7 + 3 * a[i] * u[c] + 0.5 * b[i] * v[c]);
  }
  const statistics::PrincipalComponents found = statistics::principal_components(rows, 5, 4);
  ASSERT_EQ(found.fractions.size(), 2U) << "it varies in two directions alone";
  EXPECT_NEAR(found.fractions[0] + found.fractions[1], 1, 1e-9);
  EXPECT_NEAR(found.fractions[0], 9 / 9.25, 0.01);
  for (std::size_t c = 0; c < 5; ++c) {
    EXPECT_NEAR(found.components[c], u[c], 0.02);
    EXPECT_NEAR(found.components[5 + c], v[c], 0.02);
    EXPECT_NEAR(found.mean[c], 7, 0.4);
  }
  EXPECT_THROW(statistics::principal_components(std::vector<double>(5), 5, 1), core::InputError);
  EXPECT_THROW(statistics::principal_components(std::vector<double>(11), 5, 1), core::InputError);
}

RC_GTEST_PROP(PrincipalComponents, AreOrthonormalAndTheirCoordinatesVaryAsTheirSharesSay, ()) {
  const auto rows = *rc::gen::inRange<std::size_t>(2, 14);
  const auto columns = *rc::gen::inRange<std::size_t>(1, 14);
  const auto values = drawn(rows * columns, *rc::gen::arbitrary<std::uint64_t>());
  const statistics::PrincipalComponents found =
      statistics::principal_components(values, columns, 14);
  const std::size_t count = found.fractions.size();
  RC_ASSERT(count == std::min(rows - 1, columns));
  RC_ASSERT(std::abs(std::accumulate(found.fractions.begin(), found.fractions.end(), -1.0)) < 1e-9);
  double all = 0;
  for (const double x : found.coordinates) all += x * x;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) RC_ASSERT(found.fractions[i] <= found.fractions[i - 1] * (1 + 1e-9));
    double variance = 0;
    for (std::size_t r = 0; r < rows; ++r)
      variance += std::pow(found.coordinates[r * count + i], 2);
    RC_ASSERT(std::abs(variance / all - found.fractions[i]) < 1e-9);
    for (std::size_t j = 0; j <= i; ++j) {
      double product = 0;
      for (std::size_t c = 0; c < columns; ++c) {
        product += found.components[i * columns + c] * found.components[j * columns + c];
      }
      RC_ASSERT(std::abs(product - (i == j ? 1 : 0)) < 1e-7);
    }
  }
  // All components give the rows back.
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      double value = found.mean[c];
      for (std::size_t i = 0; i < count; ++i) {
        value += found.coordinates[r * count + i] * found.components[i * columns + c];
      }
      RC_ASSERT(std::abs(value - values[r * columns + c]) < 1e-7);
    }
  }
}

TEST(ExplainedByGroups, IsOneForAValueEachAndNearZeroForNoise) {
  const std::vector<double> values = {1, 1, 4, 4};
  EXPECT_NEAR(statistics::explained_by_groups(values, std::vector<std::size_t>{0, 0, 1, 1}), 1,
              1e-12);
  EXPECT_NEAR(statistics::explained_by_groups(values, std::vector<std::size_t>{0, 1, 0, 1}), 0,
              1e-12);
  EXPECT_TRUE(std::isnan(
      statistics::explained_by_groups(std::vector<double>{2, 2}, std::vector<std::size_t>{0, 1})));
}

}  // namespace
}  // namespace carillon::eval
