#include "eval/classification/calibration.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::eval {
namespace {

// Expected values of the next two tests:
// import numpy as np; from scipy import special, optimize
// p = special.softmax(z, axis=1); confidence = p.max(1); right = p.argmax(1) == y
const std::vector<double> z = {2, 1, 0, 0.5, 2.5, -1, 3, 0, 1, -1, 0.2, 1.5, 1, 0.9, 0.8, 4, 1, 2};
const std::vector<std::size_t> y = {0, 1, 2, 2, 0, 0};
const classification::ScoreRows logits{z, 3};

TEST(FitTemperature, IsSciPys) {
  // target = np.full((6, 3), 1 / 8 / 2); target[np.arange(6), y] = 7 / 8
  // loss = lambda t: -np.mean((target * special.log_softmax(z / t, axis=1)).sum(1))
  // optimize.minimize_scalar(loss, bounds=(0.01, 50), method='bounded', options={'xatol': 1e-13})
  EXPECT_NEAR(classification::fit_temperature(logits, y), 1.3915364611912515, 1e-6);
}

TEST(Reliability, IsCountedByHand) {
  const std::vector<double> p = classification::softmax(logits);
  const auto diagram = classification::reliability({p, 3}, y);
  ASSERT_EQ(diagram.size(), 15U);
  // Confidences 0.665, 0.858, 0.844 (wrong), 0.738, 0.367, 0.844.
  EXPECT_EQ(diagram[12].samples, 3U);
  EXPECT_NEAR(diagram[12].accuracy, 2.0 / 3, 1e-15);
  EXPECT_NEAR(diagram[12].confidence, (0.85797681 + 2 * 0.84379473) / 3, 1e-8);
  EXPECT_EQ(diagram[0].samples, 0U);
  EXPECT_TRUE(std::isnan(diagram[0].accuracy));
  EXPECT_NEAR(classification::expected_calibration_error(diagram), 0.2958239612115231, 1e-14);
  EXPECT_NEAR(classification::expected_calibration_error(classification::reliability({p, 3}, y, 2)),
              0.11396853468781097, 1e-14);
}

TEST(Reliability, PutsEdgesIntoTheBinBelow) {
  const std::vector<double> p = {0.6, 0.4, 1, 0, 0.5, 0.5};
  const std::vector<std::size_t> truth = {0, 0, 0};
  const auto diagram = classification::reliability({p, 2}, truth, 5);
  EXPECT_EQ(diagram[2].samples, 2U);  // (0.4, 0.6]
  EXPECT_EQ(diagram[4].samples, 1U);
}

TEST(CalibrationErrorByChance, IsTheBinomialsMeanDeviation) {
  // One bin: the mean of |right / n - 0.7| over a binomial; scipy.stats.binom.pmf(k, 3, 0.7).
  core::RandomStream random(4, 0, "test.calibration");
  const std::vector<double> one = {0.7, 0.2, 0.1}, three = {0.7, 0.3, 0.7, 0.3, 0.7, 0.3};
  using Groups = std::vector<std::size_t>;
  EXPECT_NEAR(classification::calibration_error_by_chance({one, 3}, Groups{5}, random, 20000), 0.42,
              0.01);
  EXPECT_NEAR(
      classification::calibration_error_by_chance({three, 2}, Groups{0, 1, 2}, random, 20000),
      0.027 * 0.7 + 0.189 * (0.7 - 1.0 / 3) + 0.441 * (0.7 - 2.0 / 3) + 0.343 * 0.3, 0.005);
  // Of one group they are as one.
  EXPECT_NEAR(
      classification::calibration_error_by_chance({three, 2}, Groups{4, 4, 4}, random, 20000), 0.42,
      0.01);
  EXPECT_TRUE(std::isnan(classification::calibration_error_by_chance({{}, 2}, {}, random)));
  EXPECT_THROW(classification::calibration_error_by_chance({one, 3}, {}, random), core::InputError);
}

TEST(ExpectedCalibrationError, OfRightProbabilitiesTendsToNothing) {
  // Truth is drawn from the very probabilities; what is left is chance.
  double last = 1;
  for (const std::size_t count : {200U, 2000U, 20000U, 200000U}) {
    core::RandomStream random(3, count, "test.calibration");
    std::vector<double> p;
    std::vector<std::size_t> truth;
    for (std::size_t i = 0; i < count; ++i) {
      std::vector<double> row;
      for (int c = 0; c < 4; ++c) row.push_back(2 * random.normal());
      row = classification::softmax({row, 4});
      const double place = random.uniform();
      double sum = 0;
      std::size_t drawn = 0;
      while (drawn < 3 && (sum += row[drawn]) < place) ++drawn;
      truth.push_back(drawn);
      p.insert(p.end(), row.begin(), row.end());
    }
    const double error =
        classification::expected_calibration_error(classification::reliability({p, 4}, truth));
    EXPECT_LT(error, 0.6 * std::sqrt(15.0 / static_cast<double>(count)));
    EXPECT_LT(error, last);
    last = error;
    // Sharpened, they promise too much, and the temperature takes it back.
    std::vector<double> sharp;
    for (const double one : p) sharp.push_back(2.5 * std::log(one));
    if (count < 20000) continue;
    EXPECT_GT(classification::expected_calibration_error(
                  classification::reliability({classification::softmax({sharp, 4}), 4}, truth)),
              0.1);
    EXPECT_NEAR(classification::fit_temperature({sharp, 4}, truth), 2.5, 0.06);
  }
}

struct Drawn {
  std::size_t classes = 0;
  std::vector<double> values;
  std::vector<std::size_t> truth;
};

Drawn any_logits() {
  Drawn drawn;
  drawn.classes = *rc::gen::inRange<std::size_t>(2, 6);
  const auto count = *rc::gen::inRange<std::size_t>(1, 30);
  for (std::size_t i = 0; i < count * drawn.classes; ++i) {
    drawn.values.push_back(0.01 * *rc::gen::inRange(-500, 500));
  }
  drawn.truth = *rc::gen::container<std::vector<std::size_t>>(
      count, rc::gen::inRange<std::size_t>(0, drawn.classes));
  return drawn;
}

TEST(FitTemperature, OfScaledLogitsIsScaled) {
  EXPECT_TRUE(rc::check("T(s z) = s T(z)", [] {
    const Drawn drawn = any_logits();
    const double scale = std::pow(10, 0.1 * *rc::gen::inRange(-30, 30));
    std::vector<double> scaled;
    for (const double one : drawn.values) scaled.push_back(scale * one);
    const double fitted =
        classification::fit_temperature({drawn.values, drawn.classes}, drawn.truth);
    const double other = classification::fit_temperature({scaled, drawn.classes}, drawn.truth);
    if (fitted != 1) RC_ASSERT(std::abs(other / (scale * fitted) - 1) < 1e-5);
  }));
}

/// Mean cross-entropy with the true class but for a doubt of 1 / (n + 2).
double doubting_loss(const Drawn& drawn, double temperature) {
  std::vector<double> scaled;
  for (const double one : drawn.values) scaled.push_back(one / temperature);
  const std::vector<double> p = classification::softmax({scaled, drawn.classes});
  const auto count = static_cast<double>(drawn.truth.size());
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const bool is_true = drawn.truth[i / drawn.classes] == i % drawn.classes;
    const double target = is_true ? (count + 1) / (count + 2)
                                  : 1 / (count + 2) / (static_cast<double>(drawn.classes) - 1);
    sum -= target * std::log(p[i]) / count;
  }
  return sum;
}

TEST(FitTemperature, IsTheLeastOfAllTemperatures) {
  EXPECT_TRUE(rc::check("a minimum", [] {
    const Drawn drawn = any_logits();
    const double fitted =
        classification::fit_temperature({drawn.values, drawn.classes}, drawn.truth);
    const double other = std::pow(10, 0.1 * *rc::gen::inRange(-3, 20));
    // Chance has its minimum at infinity.
    RC_ASSERT(doubting_loss(drawn, fitted) <= doubting_loss(drawn, other) + 1e-3);
    if (fitted < 100) {
      RC_ASSERT(doubting_loss(drawn, fitted) <= doubting_loss(drawn, other) + 1e-12);
    }
  }));
}

TEST(FitTemperature, DoubtsFewSamplesThatAreAllRight) {
  // Two of two right by 3: the confidence becomes 3 / 4.
  const std::vector<double> clear = {3, 0, 0, 3};
  EXPECT_NEAR(classification::fit_temperature({clear, 2}, std::vector<std::size_t>{0, 1}),
              3 / std::log(3), 1e-9);
  // All wrong: ever less sure, down to chance.
  EXPECT_NEAR(classification::fit_temperature({clear, 2}, std::vector<std::size_t>{1, 0}), 3e3,
              1e-6);
  // Equal logits, and one class alone: nothing depends on it.
  const std::vector<double> equal(6, 0.7);
  for (const std::size_t classes : {1U, 2U, 3U}) {
    EXPECT_EQ(
        classification::fit_temperature({equal, classes}, std::vector<std::size_t>(6 / classes, 0)),
        1);
  }
}

TEST(Calibration, RefusesWhatIsNoNumber) {
  std::vector<double> bad = z;
  const auto message = [&](double value) {
    bad[10] = value;
    try {
      classification::fit_temperature({bad, 3}, y);
    } catch (const core::InputError& error) {
      return error.message();
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message(std::nan("")), "logits: row 3, column 1 is nan");
  EXPECT_EQ(message(std::numeric_limits<double>::infinity()), "logits: row 3, column 1 is inf");
  EXPECT_THROW(classification::softmax({bad, 3}), core::InputError);
  EXPECT_THROW(classification::predicted_classes({bad, 3}), core::InputError);
  EXPECT_THROW(classification::fit_temperature({{}, 3}, {}), core::InputError);
  EXPECT_THROW(classification::fit_temperature({z, 4}, y), core::InputError);
  EXPECT_THROW(classification::fit_temperature({z, 0}, y), core::InputError);
  EXPECT_THROW(classification::softmax(logits, 0), core::InputError);
  EXPECT_THROW(classification::reliability(logits, y), core::InputError);  // no probabilities
  EXPECT_THROW(classification::reliability({classification::softmax(logits), 3}, y, 0),
               core::InputError);
  EXPECT_TRUE(std::isnan(
      classification::expected_calibration_error(classification::reliability({{}, 3}, {}))));
}

TEST(PredictedClasses, AreTheFirstOfEqualScores) {
  const std::vector<double> scores = {1, 1, 0, 0, 2, 2, -1, -1, -1};
  EXPECT_EQ(classification::predicted_classes({scores, 3}), (std::vector<std::size_t>{0, 1, 0}));
}

}  // namespace
}  // namespace carillon::eval
