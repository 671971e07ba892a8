#include "eval/classification/confusion.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"

namespace carillon::eval {
namespace {

using Classes = std::vector<std::size_t>;

TEST(Confusion, IsCountedByHand) {
  const Classes truth = {0, 0, 0, 0, 1, 1, 2}, predicted = {0, 0, 0, 1, 1, 0, 1};
  const classification::Confusion confusion = classification::count_confusion(truth, predicted, 4);
  const Classes counts = {3, 1, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(confusion.counts, counts);
  EXPECT_DOUBLE_EQ(classification::accuracy(confusion), 4.0 / 7);
  const auto recall = classification::recalls(confusion);
  EXPECT_DOUBLE_EQ(recall[0], 0.75);
  EXPECT_DOUBLE_EQ(recall[1], 0.5);
  EXPECT_EQ(recall[2], 0);  // a class with one sample
  EXPECT_TRUE(std::isnan(recall[3]));
  EXPECT_DOUBLE_EQ(classification::balanced_accuracy(confusion), (0.75 + 0.5 + 0) / 3);
  const auto fractions = classification::row_fractions(confusion);
  EXPECT_DOUBLE_EQ(fractions[1], 0.25);
  EXPECT_DOUBLE_EQ(fractions[9], 1);
  EXPECT_TRUE(std::isnan(fractions[15]));
}

TEST(Confusion, AddsAnswersOfOthers) {
  const Classes truth = {0, 0, 1, 1}, first = {0, 1, 1, 1}, second = {0, 0, 0, 1};
  classification::Confusion total = classification::count_confusion(truth, first, 2);
  classification::add(total, classification::count_confusion(truth, second, 2));
  EXPECT_EQ(total.counts, (std::vector<std::size_t>{3, 1, 1, 3}));
}

TEST(Confusion, OfNoSamplesHasNoAccuracy) {
  const classification::Confusion none = classification::count_confusion({}, {}, 2);
  EXPECT_EQ(none.counts, Classes(4, 0));
  EXPECT_TRUE(std::isnan(classification::accuracy(none)));
  EXPECT_TRUE(std::isnan(classification::balanced_accuracy(none)));
  EXPECT_EQ(classification::confusion_difference(none, none).rows, 0U);
  EXPECT_TRUE(std::isnan(classification::confusion_difference(none, none).norm));
}

TEST(Confusion, OfOneClassIsRight) {
  const Classes all(5, 0);
  const classification::Confusion one = classification::count_confusion(all, all, 1);
  EXPECT_EQ(classification::accuracy(one), 1);
  EXPECT_EQ(classification::balanced_accuracy(one), 1);
}

TEST(Confusion, RefusesWhatIsNoClass) {
  EXPECT_THROW(classification::count_confusion(Classes{0}, Classes{0, 1}, 2), core::InputError);
  EXPECT_THROW(classification::count_confusion({}, {}, 0), core::InputError);
  EXPECT_THROW(classification::count_confusion(Classes{0, 1}, Classes{0, 2}, 2), core::InputError);
  try {
    classification::count_confusion(Classes{0, 1, 7}, Classes{0, 1, 1}, 2);
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("sample 2 is of class 7"), std::string::npos);
  }
}

struct Drawn {
  std::size_t classes = 0;
  Classes truth, predicted;
};

Drawn any_results() {
  Drawn drawn;
  drawn.classes = *rc::gen::inRange<std::size_t>(1, 7);
  const auto count = *rc::gen::inRange<std::size_t>(1, 60);
  const auto classes = rc::gen::inRange<std::size_t>(0, drawn.classes);
  drawn.truth = *rc::gen::container<Classes>(count, classes);
  drawn.predicted = *rc::gen::container<Classes>(count, classes);
  return drawn;
}

TEST(Confusion, OfRenamedClassesIsPermuted) {
  EXPECT_TRUE(rc::check("names of classes do not matter", [] {
    const Drawn drawn = any_results();
    Classes names(drawn.classes);
    std::iota(names.begin(), names.end(), 0);
    const auto turn = *rc::gen::inRange<std::size_t>(0, drawn.classes);
    std::rotate(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(turn), names.end());
    if (drawn.classes > 1) std::swap(names[0], names[1]);
    const auto renamed = [&](const Classes& old) {
      Classes now;
      for (const std::size_t c : old) now.push_back(names[c]);
      return now;
    };
    const classification::Confusion one =
        classification::count_confusion(drawn.truth, drawn.predicted, drawn.classes);
    const classification::Confusion other = classification::count_confusion(
        renamed(drawn.truth), renamed(drawn.predicted), drawn.classes);
    for (std::size_t t = 0; t < drawn.classes; ++t) {
      for (std::size_t p = 0; p < drawn.classes; ++p) {
        RC_ASSERT(one.at(t, p) == other.at(names[t], names[p]));
      }
    }
    RC_ASSERT(classification::accuracy(one) == classification::accuracy(other));
    RC_ASSERT(std::abs(classification::balanced_accuracy(one) -
                       classification::balanced_accuracy(other)) < 1e-12);
  }));
}

TEST(BalancedAccuracy, IsTheAccuracyOfClassesOfOneSize) {
  EXPECT_TRUE(rc::check("of equal numbers", [] {
    Drawn drawn = any_results();
    for (std::size_t i = 0; i < drawn.truth.size(); ++i) drawn.truth[i] = i % drawn.classes;
    const std::size_t whole = drawn.truth.size() / drawn.classes * drawn.classes;
    RC_PRE(whole > 0);
    drawn.truth.resize(whole);
    drawn.predicted.resize(whole);
    const classification::Confusion confusion =
        classification::count_confusion(drawn.truth, drawn.predicted, drawn.classes);
    RC_ASSERT(std::abs(classification::accuracy(confusion) -
                       classification::balanced_accuracy(confusion)) < 1e-12);
  }));
}

TEST(ConfusionDifference, OfOppositeMatricesIsTheGreatest) {
  for (std::size_t k = 2; k < 6; ++k) {
    Classes truth(3 * k), wrong(3 * k);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      truth[i] = i % k;
      wrong[i] = (i + 1) % k;
    }
    const auto right = classification::count_confusion(truth, truth, k),
               none = classification::count_confusion(truth, wrong, k);
    EXPECT_NEAR(classification::confusion_difference(right, none).norm,
                std::sqrt(2.0 * static_cast<double>(k)), 1e-12);
  }
}

TEST(ConfusionDifference, ComparesSharesOfClassesInBoth) {
  // Rows (3/4, 1/4) against (1/2, 1/2): sqrt(2) / 4; class 1 is in the first alone.
  const auto first =
      classification::count_confusion(Classes{0, 0, 0, 0, 1}, Classes{0, 0, 0, 1, 1}, 2);
  const auto second = classification::count_confusion(Classes{0, 0}, Classes{0, 1}, 2);
  EXPECT_NEAR(classification::confusion_difference(first, second).norm, std::sqrt(2.0) / 4, 1e-15);
  EXPECT_EQ(classification::confusion_difference(first, second).rows, 1U);
  EXPECT_THROW(
      classification::confusion_difference(first, classification::count_confusion({}, {}, 3)),
      core::InputError);
}

TEST(ConfusionDifference, IsADistance) {
  EXPECT_TRUE(rc::check("zero, symmetric, triangle", [] {
    const auto k = *rc::gen::inRange<std::size_t>(1, 5);
    const auto classes = rc::gen::inRange<std::size_t>(0, k);
    const auto draw = [&] {
      // Every class occurs, so that the same rows are compared.
      Classes truth = *rc::gen::container<Classes>(*rc::gen::inRange<std::size_t>(0, 30), classes);
      for (std::size_t c = 0; c < k; ++c) truth.push_back(c);
      return classification::count_confusion(
          truth, *rc::gen::container<Classes>(truth.size(), classes), k);
    };
    const classification::Confusion a = draw(), b = draw(), c = draw();
    RC_ASSERT(classification::confusion_difference(a, a).norm == 0);
    const double ab = classification::confusion_difference(a, b).norm;
    RC_ASSERT(ab == classification::confusion_difference(b, a).norm);
    RC_ASSERT(ab <= classification::confusion_difference(a, c).norm +
                        classification::confusion_difference(c, b).norm + 1e-12);
    RC_ASSERT(ab <= std::sqrt(2.0 * static_cast<double>(k)) + 1e-12);
  }));
}

}  // namespace
}  // namespace carillon::eval
