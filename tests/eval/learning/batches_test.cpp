// How samples come to ranks and steps, and when training ends.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/error.hpp"
#include "eval/learning/batches.hpp"
#include "eval/learning/epochs.hpp"
#include "tests/eval/learning/made_source.hpp"

namespace carillon::eval {
namespace {

RC_GTEST_PROP(RowsOfRanks, AreSharedOutWithoutRestAndEvenly, ()) {
  const auto count = *rc::gen::inRange<std::size_t>(0, 3000);
  const int size = *rc::gen::inRange(1, 9);
  std::vector<std::uint32_t> rows(count);
  for (std::size_t i = 0; i < count; ++i) rows[i] = static_cast<std::uint32_t>(3 * i);
  std::multiset<std::uint32_t> all;
  std::size_t minimum = count, maximum = 0;
  for (int rank = 0; rank < size; ++rank) {
    const auto own = learning::rows_of_rank(rows, rank, size);
    RC_ASSERT(std::is_sorted(own.begin(), own.end()));
    all.insert(own.begin(), own.end());
    minimum = std::min(minimum, own.size());
    maximum = std::max(maximum, own.size());
  }
  RC_ASSERT(std::vector<std::uint32_t>(all.begin(), all.end()) == rows);
  RC_ASSERT(maximum - minimum <= 1 + count / (16 * static_cast<std::size_t>(size)));
}

std::vector<std::uint32_t> one_pass(learning::BatchReader& reader,
                                    std::optional<std::uint64_t> order) {
  std::vector<std::uint32_t> rows;
  reader.begin(order);
  for (learning::Batch batch; reader.next(7, batch);) {
    rows.insert(rows.end(), batch.rows.begin(), batch.rows.end());
  }
  return rows;
}

/// A method of these modalities that gets them as they are.
learning::Method perceiving(std::vector<learning::Modality> modalities) {
  learning::Method method = made_method({});
  method.modalities = std::move(modalities);
  return method;
}

/// Memory for all samples, or for two windows of 64.
class Batches : public testing::TestWithParam<double> {};

TEST_P(Batches, HoldEverySampleOnceWithItsOwnValuesInAnOrderOfTheSeed) {
  MadeSource source(600, 3);
  const auto samples = learning::label_samples(source, made_task());
  const auto rows = samples.rows(learning::Part::train);
  learning::BatchReader reader(
      source, samples, perceiving({learning::Modality::spectrogram, learning::Modality::voxels}),
      rows, GetParam());
  const auto first = one_pass(reader, 1), again = one_pass(reader, 1), other = one_pass(reader, 2);
  EXPECT_EQ(first, again);
  EXPECT_NE(first, other);
  EXPECT_NE(first, rows);
  auto sorted = other;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, rows);
  EXPECT_EQ(one_pass(reader, {}), rows);
  reader.begin(3);
  learning::Batch batch;
  ASSERT_TRUE(reader.next(10, batch));
  for (std::size_t i = 0; i < 10; ++i) {
    std::vector<float> own(96), object(1728);
    source.read(learning::Modality::spectrogram, std::vector<std::uint32_t>{batch.rows[i]}, own);
    source.read(learning::Modality::voxels, std::vector<std::uint32_t>{batch.rows[i] % 3}, object);
    EXPECT_TRUE(std::equal(own.begin(), own.end(),
                           batch.modalities[0].begin() + static_cast<std::ptrdiff_t>(i * 96)));
    EXPECT_TRUE(std::equal(object.begin(), object.end(),
                           batch.modalities[1].begin() + static_cast<std::ptrdiff_t>(i * 1728)));
    EXPECT_EQ(batch.labels[i], batch.rows[i] % 3);
  }
}
INSTANTIATE_TEST_SUITE_P(InMemoryAndInWindows, Batches, testing::Values(1e9, 128 * 96 * 4.0));

TEST(Batches, ScaleSpectrogramsAsTheMethodWantsThem) {
  MadeSource source(300, 3);
  const auto samples = learning::label_samples(source, made_task());
  learning::Method method =
      perceiving({learning::Modality::spectrogram, learning::Modality::waveform});
  const auto first_of = [&] {
    learning::BatchReader reader(source, samples, method, {0, 1}, 1e9);
    reader.begin({});
    learning::Batch batch;
    EXPECT_TRUE(reader.next(1, batch));
    return batch.modalities;
  };
  const auto power = first_of();
  method.spectrogram = {learning::SpectrogramScale::decibels, 20};
  const auto decibels = first_of();
  EXPECT_EQ(decibels[1], power[1]);
  for (std::size_t i = 0; i < power[0].size(); ++i) {
    const double level = power[0][i] > 0 ? 10 * std::log10(double{power[0][i]}) : -1e9;
    EXPECT_NEAR(decibels[0][i], std::max(0.0, 1 + level / 20), 1e-6) << i;
  }
}

TEST(Batches, ThatFitAreReadOnce) {
  MadeSource source(600, 3);
  const auto samples = learning::label_samples(source, made_task());
  learning::BatchReader reader(source, samples, perceiving({learning::Modality::spectrogram}),
                               samples.rows(learning::Part::train), 1e9);
  for (std::uint64_t pass = 0; pass < 4; ++pass) one_pass(reader, pass);
  EXPECT_EQ(source.reads, samples.rows(learning::Part::train).size());
}

TEST(Batches, CountSilenceOnceAndNameWhatIsMissing) {
  MadeSource source(600, 3);
  source.silent = 15;
  const auto samples = learning::label_samples(source, made_task());
  learning::BatchReader reader(source, samples, perceiving({learning::Modality::spectrogram}),
                               samples.rows(learning::Part::train), 128 * 96 * 4);
  for (std::uint64_t pass = 0; pass < 3; ++pass) one_pass(reader, pass);
  EXPECT_EQ(reader.silent(), 1u);
  EXPECT_THROW(
      learning::BatchReader(source, samples, perceiving({learning::Modality::touch}), {0, 1}, 1e9),
      core::InputError);
}

TEST(Batches, PassOnWhatAnotherThreadMet) {
  MadeSource source(600, 3);
  source.not_finite = 300;
  const auto samples = learning::label_samples(source, made_task());
  learning::BatchReader reader(source, samples, perceiving({learning::Modality::spectrogram}),
                               samples.rows(learning::Part::train), 128 * 96 * 4);
  EXPECT_THROW(one_pass(reader, {}), core::InputError);
}

learning::Epoch epoch_of(std::int64_t number, double validation_loss) {
  return {.number = number, .validation_loss = validation_loss};
}

TEST(Epochs, KeepTheBestAndEndAfterThePatience) {
  const learning::LearningOptions options{.epochs = 20, .patience = 3};
  std::vector<learning::Epoch> epochs = {epoch_of(1, 2), epoch_of(2, 1), epoch_of(3, 1.5),
                                         epoch_of(4, 1)};
  EXPECT_EQ(learning::best_of(epochs), 2);
  EXPECT_FALSE(learning::ends_after(epochs, options));
  epochs.push_back(epoch_of(5, 3));
  EXPECT_TRUE(learning::ends_after(epochs, options));
  epochs[4] = epoch_of(5, 0.5);
  EXPECT_EQ(learning::best_of(epochs), 5);
  EXPECT_FALSE(learning::ends_after(epochs, options));
  // Without samples to validate with, the last.
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(learning::best_of({epoch_of(1, none), epoch_of(2, none)}), 2);
  EXPECT_EQ(learning::best_of({}), 0);
}

TEST(Epochs, LowerTheLearningRateWhereNothingGetsBetter) {
  const learning::LearningOptions options{.patience = 4, .learning_rate = 0.9};
  std::vector<learning::Epoch> epochs = {epoch_of(1, 2), epoch_of(2, 1)};
  EXPECT_DOUBLE_EQ(learning::learning_rate_after(epochs, options), 0.9);
  epochs.push_back(epoch_of(3, 1));
  EXPECT_DOUBLE_EQ(learning::learning_rate_after(epochs, options), 0.9);
  epochs.push_back(epoch_of(4, 1.1));
  EXPECT_DOUBLE_EQ(learning::learning_rate_after(epochs, options), 0.3);
  epochs.push_back(epoch_of(5, 0.5));
  epochs.push_back(epoch_of(6, 0.6));
  EXPECT_DOUBLE_EQ(learning::learning_rate_after(epochs, options), 0.3);
}

TEST(Epochs, FollowHalfACosineToTheLastWhateverTheLossIs) {
  const learning::LearningOptions options{
      .epochs = 4, .patience = 1, .learning_rate = 0.8, .schedule = learning::Schedule::cosine};
  std::vector<learning::Epoch> epochs;
  const double expected[] = {0.8, 0.4 * (1 + std::sqrt(0.5)), 0.4, 0.4 * (1 - std::sqrt(0.5))};
  for (const double rate : expected) {
    EXPECT_FALSE(learning::ends_after(epochs, options));
    EXPECT_NEAR(learning::learning_rate_after(epochs, options), rate, 1e-15);
    epochs.push_back(epoch_of(static_cast<std::int64_t>(epochs.size()) + 1, 3));
  }
  EXPECT_TRUE(learning::ends_after(epochs, options));
}

}  // namespace
}  // namespace carillon::eval
