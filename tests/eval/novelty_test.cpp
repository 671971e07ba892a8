#include "eval/classification/novelty.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::eval {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(Auroc, IsSciPys) {
  // scipy.stats.mannwhitneyu(known, novel).statistic / 20
  const std::vector<double> known = {0.9, 0.8, 0.8, 0.4, 0.35}, novel = {0.8, 0.5, 0.4, 0.1};
  EXPECT_NEAR(auroc(known, novel), 0.675, 1e-15);
}

TEST(Auroc, HasStatedEnds) {
  const std::vector<double> low = {-infinity, 1, 2}, high = {3, 4, infinity};
  EXPECT_EQ(auroc(high, low), 1);
  EXPECT_EQ(auroc(low, high), 0);
  EXPECT_EQ(auroc(std::vector<double>(5, 2), std::vector<double>(3, 2)), 0.5);
  EXPECT_TRUE(std::isnan(auroc({}, low)));
  EXPECT_TRUE(std::isnan(auroc(low, {})));
  try {
    auroc(low, std::vector{1.0, std::nan("")});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_EQ(error.message(), "novel score 1 is no number");
  }
}

std::vector<double> any_scores() {
  std::vector<double> scores;
  for (const int one :
       *rc::gen::nonEmpty(rc::gen::container<std::vector<int>>(rc::gen::inRange(-20, 20)))) {
    scores.push_back(0.25 * one);
  }
  return scores;
}

TEST(Auroc, IsTheShareOfPairsAndHeedsOrderAlone) {
  EXPECT_TRUE(rc::check("pairs, monotone maps, exchange", [] {
    const auto known = any_scores(), novel = any_scores();
    double pairs = 0;
    for (const double a : known) {
      for (const double b : novel) pairs += a > b ? 1 : (a == b ? 0.5 : 0);
    }
    const double area = auroc(known, novel);
    RC_ASSERT(std::abs(area - pairs / static_cast<double>(known.size() * novel.size())) < 1e-12);
    const auto mapped = [](std::vector<double> scores) {
      for (double& one : scores) one = std::exp(one) + one * one * one;
      return scores;
    };
    RC_ASSERT(auroc(mapped(known), mapped(novel)) == area);
    RC_ASSERT(std::abs(auroc(novel, known) - (1 - area)) < 1e-12);
  }));
}

TEST(ThresholdAt, IsReachedByTheShareAskedFor) {
  std::vector<double> known;
  for (int i = 1; i <= 20; ++i) known.push_back(i);
  EXPECT_EQ(threshold_at(known, 0.95), 2);
  EXPECT_EQ(threshold_at(known, 1), 1);
  EXPECT_EQ(threshold_at(known, 0.15), 18);
  EXPECT_EQ(threshold_at(known, 1e-9), 20);
  EXPECT_EQ(share_reaching(std::vector<double>{1, 2, 3, 0}, 2), 0.5);
  EXPECT_TRUE(std::isnan(share_reaching({}, 2)));
  EXPECT_THROW(threshold_at({}, 0.95), core::InputError);
  EXPECT_THROW(threshold_at(known, 0), core::InputError);
  EXPECT_THROW(threshold_at(known, 1.01), core::InputError);
  EXPECT_TRUE(rc::check("the greatest such threshold", [] {
    const auto scores = any_scores();
    const double rate = *rc::gen::inRange(1, 101) / 100.0;
    const double threshold = threshold_at(scores, rate);
    RC_ASSERT(share_reaching(scores, threshold) >= rate - 1e-9);
    RC_ASSERT(share_reaching(scores, std::nextafter(threshold, infinity)) < rate);
  }));
}

TEST(EnergyScores, AreSciPys) {
  // scipy.special.logsumexp(z, axis=1), 2 * scipy.special.logsumexp(z / 2, axis=1)
  const std::vector<double> z = {2, 1, 0, 0.5, 2.5, -1};
  const auto scores = energy_scores({z, 3}), warm = energy_scores({z, 3}, 2);
  EXPECT_NEAR(scores[0], 2.40760596, 1e-8);
  EXPECT_NEAR(scores[1], 2.65317821, 1e-8);
  EXPECT_NEAR(warm[0], 3.36053934, 1e-8);
  EXPECT_NEAR(warm[1], 3.36571093, 1e-8);
  EXPECT_NEAR(softmax_scores({z, 3})[0], 0.66524096, 1e-8);
  EXPECT_EQ(energy_scores({std::vector{1e308, 0.0}, 2})[0], 1e308);
  // A common shift of a row moves its energy, and not its probabilities.
  const std::vector<double> shifted = {7, 6, 5};
  EXPECT_NEAR(energy_scores({shifted, 3})[0], 7.40760596, 1e-8);
  EXPECT_NEAR(softmax_scores({shifted, 3})[0], 0.66524096, 1e-8);
  EXPECT_THROW(energy_scores({std::vector{infinity, 0.0}, 2}), core::InputError);
  EXPECT_THROW(energy_scores({z, 3}, 0), core::InputError);
}

TEST(MahalanobisScores, AreNumPys) {
  // import numpy as np; C = np.array([x - X[t == c].mean(0) for x, c in zip(X, t)]); n = len(C)
  // S = C.T @ C / n; m = np.trace(S) / 3; d2 = np.sum((S - m * np.eye(3))**2)
  // b2 = sum(np.sum((np.outer(x, x) - S)**2) for x in C) / n**2; rho = min(b2, d2) / d2
  // V = np.linalg.inv((1 - rho) * S + rho * m * np.eye(3)); max over c of -(x - mu) @ V @ (x - mu)
  const std::vector<double> x = {1, 2,   0.5,  1.2, 1.8, 0.1,  0.7, 2.4, 0.3, 4, -1,
                                 2, 4.4, -1.3, 2.2, 3.9, -0.6, 1.7, 0,   0,   5};
  const std::vector<std::size_t> truth = {0, 0, 0, 1, 1, 1, 3};  // class 2 does not occur
  const std::vector<double> asked = {1, 2, 1, 2.5, 0, 1, 0, 0, 5};
  const auto fitted = fit_gaussians({x, 3}, truth, 4);
  EXPECT_NEAR(fitted.shrinkage, 0.3776590642455009, 1e-12);
  EXPECT_EQ(fitted.centres.cols(), 3);
  auto scores = mahalanobis_scores(fitted, {asked, 3});
  EXPECT_NEAR(scores[0], -14.772495602094677, 1e-9);
  EXPECT_NEAR(scores[1], -81.17029234846356, 1e-9);
  EXPECT_NEAR(scores[2], 0, 1e-12);
  scores = mahalanobis_scores(fit_gaussians({x, 3}, truth, 4, 0.1), {asked, 3});
  EXPECT_NEAR(scores[0], -18.20087445459352, 1e-9);
  EXPECT_NEAR(scores[1], -72.72945426309555, 1e-9);
}

/// Two Gaussian classes of unlike widths of their features, 12 apart along the first.
std::vector<double> drawn_features(std::size_t count, std::size_t columns,
                                   core::RandomStream& random) {
  std::vector<double> x;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < columns; ++k) {
      x.push_back((k == 0 && i % 2 == 1 ? 12 : 0) + static_cast<double>(k + 1) * random.normal());
    }
  }
  return x;
}

std::vector<std::size_t> alternating(std::size_t count) {
  std::vector<std::size_t> truth(count);
  for (std::size_t i = 0; i < count; ++i) truth[i] = i % 2;
  return truth;
}

TEST(MahalanobisScores, OfGaussiansAreChiSquared) {
  core::RandomStream random(9, 1, "test.novelty");
  const std::size_t columns = 6, count = 20000;
  const auto x = drawn_features(count, columns, random);
  const auto fitted = fit_gaussians({x, columns}, alternating(count), 2);
  EXPECT_LT(fitted.shrinkage, 0.01);
  const auto scores = mahalanobis_scores(fitted, {drawn_features(count, columns, random), columns});
  double mean = 0, square = 0;
  for (const double one : scores) {
    mean -= one / static_cast<double>(count);
    square += one * one / static_cast<double>(count);
  }
  EXPECT_NEAR(mean, 6, 0.15);
  EXPECT_NEAR(square - mean * mean, 12, 0.8);
}

TEST(FitGaussians, OfFewerSamplesThanFeaturesStillTellsNovelOnes) {
  core::RandomStream random(9, 2, "test.novelty");
  const std::size_t columns = 64;
  const auto draw = [&](std::size_t count, double novelty) {
    std::vector<double> x;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < columns; ++k) {
        x.push_back(random.normal() + (k % 2 == i % 2 ? 2 : 0) + (k < 8 ? novelty : 0));
      }
    }
    return x;
  };
  const auto fitted = fit_gaussians({draw(16, 0), columns}, alternating(16), 2);
  EXPECT_GT(fitted.shrinkage, 0.2);
  const auto known = mahalanobis_scores(fitted, {draw(200, 0), columns});
  const auto novel = mahalanobis_scores(fitted, {draw(200, 3), columns});
  EXPECT_GT(auroc(known, novel), 0.95);
  // Without it there is hardly an inverse; distances stay finite.
  for (const double one : mahalanobis_scores(
           fit_gaussians({draw(16, 0), columns}, alternating(16), 2, 0), {draw(4, 0), columns})) {
    EXPECT_TRUE(std::isfinite(one));
  }
}

TEST(MahalanobisScores, DoNotDependOnUnitOrDirection) {
  EXPECT_TRUE(rc::check("turned and scaled", [] {
    core::RandomStream random(*rc::gen::inRange(0, 1000), 3, "test.novelty");
    const auto x = drawn_features(12, 2, random), asked = drawn_features(5, 2, random);
    const double angle = random.uniform(0, 6), scale = random.log_uniform(1e-6, 1e6);
    const auto turned = [&](std::vector<double> rows) {
      for (std::size_t i = 0; i < rows.size(); i += 2) {
        const double a = rows[i], b = rows[i + 1];
        rows[i] = scale * (std::cos(angle) * a - std::sin(angle) * b) + 3 * scale;
        rows[i + 1] = scale * (std::sin(angle) * a + std::cos(angle) * b);
      }
      return rows;
    };
    const auto one = mahalanobis_scores(fit_gaussians({x, 2}, alternating(12), 2), {asked, 2});
    const auto other =
        mahalanobis_scores(fit_gaussians({turned(x), 2}, alternating(12), 2), {turned(asked), 2});
    for (std::size_t i = 0; i < one.size(); ++i) {
      RC_ASSERT(std::abs(one[i] - other[i]) < 1e-6 * (1 + std::abs(one[i])));
    }
  }));
}

TEST(FitGaussians, RefusesWhatHasNoSpread) {
  const std::vector<double> equal = {0.1, 0.7, 0.1, 0.7, 0.1, 0.7};
  const std::vector<std::size_t> one(3, 0), each = {0, 1, 2};
  EXPECT_THROW(fit_gaussians({equal, 2}, one, 1), core::InputError);
  // One sample of each class.
  const std::vector<double> x = {1, 2, 3, 4, 5, 6};
  EXPECT_THROW(fit_gaussians({x, 2}, each, 3), core::InputError);
  EXPECT_THROW(fit_gaussians({{}, 2}, {}, 1), core::InputError);
  EXPECT_THROW(fit_gaussians({x, 2}, one, 1, 1.5), core::InputError);
  const auto fitted = fit_gaussians({x, 2}, one, 1);
  EXPECT_THROW(mahalanobis_scores(fitted, {x, 3}), core::InputError);
  std::vector<double> bad = x;
  bad[3] = std::nan("");
  try {
    mahalanobis_scores(fitted, {bad, 2});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_EQ(error.message(), "features: row 1, column 1 is nan");
  }
}

}  // namespace
}  // namespace carillon::eval
