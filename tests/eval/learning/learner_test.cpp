// Training: what is learnt, that it is the same again, goes on as if it had not stopped, and what
// becomes of bad samples and damaged checkpoints.
#include <gtest/gtest.h>

#include <array>
#include <barrier>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"
#include "eval/learning/batches.hpp"
#include "eval/networks/detail/linear_machine.hpp"
#include "eval/networks/nearest_neighbour.hpp"
#include "eval/networks/training.hpp"
#include "tests/eval/learning/made_course.hpp"

namespace carillon::eval {
namespace {

learning::Method svm(std::vector<learning::Modality> modalities) {
  learning::Method method = made_method({});
  method.kind = learning::MethodKind::linear_svm;
  method.modalities = std::move(modalities);
  return method;
}

TEST(Training, LearnsWhatTellsClassesApart) {
  MadeSource source(600, 3);
  const Course run = train(made_method({learning::Branch::isnn}), source);
  EXPECT_GT(run.test_accuracy, 0.98);
  EXPECT_EQ(run.trained.epochs.size(), 8u);
  EXPECT_LT(run.trained.epochs.back().train_loss, run.trained.epochs.front().train_loss / 2);
}

TEST(Training, OfALinearSupportVectorMachineLearnsToo) {
  MadeSource source(600, 3);
  EXPECT_GT(train(svm({learning::Modality::spectrogram}), source).test_accuracy, 0.95);
}

TEST(Training, IsTheSameAgainAndAnotherOfAnotherSeed) {
  MadeSource source(300, 3, 1.5);
  learning::Method method = made_method({learning::Branch::isnn});
  const Course first = train(method, source), again = train(method, source);
  EXPECT_EQ(first.scores, again.scores);
  method.learning.seed = 5;
  EXPECT_NE(train(method, source).scores, first.scores);
}

TEST(Training, GoesOnAsIfItHadNotStopped) {
  const core::TemporaryFolder folder;
  const networks::Checkpoint checkpoint{folder.path() / "checkpoint", "inputs"};
  MadeSource source(300, 3, 1.0);
  for (const learning::Branch branch : {learning::Branch::soundnet5, learning::Branch::isnn}) {
    const learning::Method method = made_method({branch});
    learning::Method shorter = method;
    shorter.learning.epochs = 4;
    const Course whole = train(shorter, source);
    int steps = 0;
    networks::LearningWatch watch;
    watch.stop = [&] { return ++steps == 25; };  // in the third epoch of 180 samples
    const Course stopped = train(shorter, source, checkpoint, watch);
    ASSERT_TRUE(stopped.trained.interrupted);
    ASSERT_EQ(stopped.trained.epochs.size(), 2u);
    const Course rest = train(shorter, source, checkpoint);
    EXPECT_EQ(rest.trained.resumed, 2);
    EXPECT_EQ(rest.trained.epochs.size(), 4u);
    EXPECT_EQ(rest.scores, whole.scores);
    for (std::size_t e = 0; e < 4; ++e) {
      EXPECT_EQ(rest.trained.epochs[e].train_loss, whole.trained.epochs[e].train_loss);
    }
    std::filesystem::remove(checkpoint.file);
  }
}

/// Two ranks as threads of one process.
class TwoRanks {
 public:
  networks::LearningRanks of(int rank) {
    networks::LearningRanks ranks;
    ranks.rank = rank;
    ranks.size = 2;
    ranks.sum = [this, rank](std::span<float> values) {
      auto& own = values_[static_cast<std::size_t>(rank)];
      const auto& other = values_[static_cast<std::size_t>(1 - rank)];
      own.assign(values.begin(), values.end());
      meet_.arrive_and_wait();
      for (std::size_t i = 0; i < values.size(); ++i) values[i] += other.at(i);
      meet_.arrive_and_wait();
    };
    return ranks;
  }

 private:
  std::array<std::vector<float>, 2> values_;
  std::barrier<> meet_{2};
};

TEST(Training, OfTwoRanksMovesByTheMeanGradientOfAllSamples) {
  // Without anything random; Adam heeds a gradient's scale against the decay of weights alone.
  // Every step sees all samples, of which one rank has more.
  MadeSource source(520, 3, 1.0);
  learning::Method method = made_method({learning::Branch::isnn});
  method.sizes.dropout = 0;
  method.learning.epochs = 4;
  method.learning.weight_decay = 0.1;
  method.learning.batch = 2000;
  const Course alone = train(method, source);
  const learning::LabelledSamples samples = learning::label_samples(source, made_task());
  const auto rows = samples.rows(learning::Part::test), all = samples.rows(learning::Part::train);
  EXPECT_NE(learning::rows_of_rank(all, 0, 2).size(), learning::rows_of_rank(all, 1, 2).size());
  std::vector<networks::Learner> learners;
  for (int rank = 0; rank < 2; ++rank) {
    learners.emplace_back(method, extents_of(method, source), samples.classes);
  }
  TwoRanks ranks;
  std::array<std::vector<float>, 2> scores;
  std::vector<std::jthread> threads;
  for (const int rank : {0, 1}) {
    threads.emplace_back([&, rank] {
      MadeSource own(520, 3, 1.0);
      const auto place = static_cast<std::size_t>(rank);
      learners[place].train(own, samples, ranks.of(rank), {}, {});
      scores[place] = learners[place].predict(own, samples, rows, ranks.of(rank));
    });
  }
  threads.clear();
  EXPECT_EQ(scores[0], scores[1]);
  ASSERT_EQ(scores[0].size(), alone.scores.size());
  const float maximum = *std::max_element(alone.scores.begin(), alone.scores.end());
  EXPECT_GT(maximum, 0.05F);
  for (std::size_t i = 0; i < alone.scores.size(); ++i) {
    EXPECT_NEAR(scores[0][i], alone.scores[i], 1e-3F * maximum) << i;
  }
}

TEST(LinearMachines, OfTwoRanksAreThoseOfOne) {
  const learning::Method method = svm({learning::Modality::spectrogram});
  MadeSource source(520, 3, 1.0);
  const learning::LabelledSamples samples = learning::label_samples(source, made_task());
  const auto rows = samples.rows(learning::Part::test);
  const Course alone = train(method, source);
  EXPECT_EQ(train(method, source).scores, alone.scores);
  TwoRanks ranks;
  std::array<std::vector<float>, 2> scores;
  std::vector<std::jthread> threads;
  for (const int rank : {0, 1}) {
    threads.emplace_back([&, rank] {
      MadeSource own(520, 3, 1.0);
      networks::Learner learner(method, extents_of(method, own), samples.classes);
      learner.train(own, samples, ranks.of(rank), {}, {});
      scores[static_cast<std::size_t>(rank)] = learner.predict(own, samples, rows, ranks.of(rank));
    });
  }
  threads.clear();
  EXPECT_EQ(scores[0], scores[1]);
  // Threads share liblinear's random numbers, so that these two, unlike processes, end elsewhere
  // within its tolerance.
  const float maximum = *std::max_element(alone.scores.begin(), alone.scores.end());
  for (std::size_t i = 0; i < alone.scores.size(); ++i) {
    EXPECT_NEAR(scores[0][i], alone.scores[i], 0.1F * maximum) << i;
  }
}

TEST(LinearMachines, HaveTheWidestMarginOfFourPoints) {
  // (1, 0), (2, 1) on one side of (-1, 0), (-2, -1): with a great cost the margin's half is 1 along
  // x, so that the normal with the regularised offset is (1, 0, 0).
  networks::LinearSamples samples(2);
  for (const auto& [x, y, label] : {std::tuple{1.0F, 0.0F, 1}, std::tuple{2.0F, 1.0F, 1},
                                    std::tuple{-1.0F, 0.0F, 0}, std::tuple{-2.0F, -1.0F, 0}}) {
    samples.add(std::array{x, y}, label);
  }
  const std::vector<double> plane = networks::one_against_rest(samples, 1, 1e4, 1);
  const std::vector<double> other = networks::one_against_rest(samples, 0, 1e4, 1);
  const double expected[] = {1, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(plane[i], expected[i], 0.02);
    EXPECT_NEAR(other[i], -expected[i], 0.02);
  }
  // Nothing on the other side: everything is on this one.
  EXPECT_EQ(networks::one_against_rest(samples, 7, 1, 1), (std::vector<double>{0, 0, -1}));
}

TEST(LinearMachines, LearnFromWhatFitsIntoMemory) {
  MadeSource source(600, 3);
  learning::Method method = svm({learning::Modality::spectrogram});
  method.learning.memory = 100 * networks::LinearSamples::bytes_of(96);
  const Course run = train(method, source);
  ASSERT_EQ(run.trained.remarks.size(), 1u);
  EXPECT_NE(run.trained.remarks.front().find("100 of 360"), std::string::npos);
  EXPECT_GT(run.test_accuracy, 0.9);
}

TEST(Training, RefusesAValidationLossThatIsNoNumber) {
  MadeSource source(300, 3);
  const learning::LabelledSamples samples = learning::label_samples(source, made_task());
  learning::Method method = made_method({learning::Branch::isnn});
  method.learning.learning_rate = 1e37;  // the step after which nothing is finite is the last
  method.learning.batch = 1000;
  networks::Learner learner(method, extents_of(method, source), samples.classes);
  EXPECT_THROW(learner.train(source, samples, {}, {}, {}), core::InputError);
}

TEST(Training, EndsWhereNothingGetsBetterAndKeepsTheBestWeights) {
  MadeSource source(150, 3, 3.0);  // noise: it learns by heart, and validation shows it
  learning::Method method = made_method({learning::Branch::isnn});
  method.learning.epochs = 100;
  method.learning.patience = 5;
  method.learning.learning_rate = 5e-3;
  const Course run = train(method, source);
  const auto& epochs = run.trained.epochs;
  ASSERT_LT(epochs.size(), 100u);
  EXPECT_EQ(static_cast<std::int64_t>(epochs.size()), run.trained.best + 5);
  const learning::LabelledSamples samples = learning::label_samples(source, made_task());
  networks::Learner learner(method, extents_of(method, source), samples.classes);
  learner.train(source, samples, {}, {}, {});
  const auto rows = samples.rows(learning::Part::validation);
  const auto scores = learner.predict(source, samples, rows, {});
  EXPECT_NEAR(accuracy_of(scores, rows, samples),
              epochs[static_cast<std::size_t>(run.trained.best - 1)].validation_accuracy, 1e-6);
}

TEST(SavedLearner, AnswersAsItDid) {
  const core::TemporaryFolder folder;
  MadeSource source(300, 3);
  const learning::LabelledSamples samples = learning::label_samples(source, made_task());
  learning::Method method =
      made_method({learning::Branch::isnn, learning::Branch::voxnet}, learning::Fusion::multiply);
  method.learning.epochs = 1;
  networks::Learner learner(method, extents_of(method, source), samples.classes);
  learner.train(source, samples, {}, {}, {});
  learner.save(folder.path() / "model");
  networks::Learner loaded = networks::Learner::load(folder.path() / "model");
  EXPECT_EQ(loaded.classes(), samples.classes);
  EXPECT_EQ(learning::to_json(loaded.method()), learning::to_json(method));
  const auto rows = samples.rows(learning::Part::test);
  const auto scores = learner.predict(source, samples, rows, {});
  EXPECT_EQ(loaded.predict(source, samples, rows, {}), scores);
  // One at a time, from prepared values.
  std::vector<float> sound(96), object(1728);
  source.read(learning::Modality::spectrogram, std::vector<std::uint32_t>{rows[0]}, sound);
  source.read(learning::Modality::voxels, std::vector<std::uint32_t>{rows[0] % 3}, object);
  const auto alone = loaded.logits_of({sound, object});
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(alone[c], scores[c], 1e-5);
}

TEST(ExcitingInput, IsTakenForItsClassAndAsStrongAsAsked) {
  MadeSource source(300, 3);
  const learning::LabelledSamples samples = learning::label_samples(source, made_task());
  learning::Method method = made_method({learning::Branch::isnn}, learning::Fusion::concatenate);
  method.learning.epochs = 8;
  networks::Learner learner(method, extents_of(method, source), samples.classes);
  learner.train(source, samples, {}, {}, {});
  const std::vector<float> even(learning::values_in(extents_of(method, source).front()), 0.7F);
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<float> input = learner.exciting_input(c, even, 0.1);
    double square = 0;
    for (const float value : input) {
      EXPECT_GE(value, 0);
      EXPECT_LE(value, 1);
      square += static_cast<double>(value) * value / static_cast<double>(input.size());
    }
    EXPECT_LE(square, 0.1001);
    EXPECT_GT(square, 0.05);
    const std::vector<float> logits = learner.logits_of({input});
    const std::vector<float> plain =
        learner.logits_of({std::vector<float>(input.size(), std::sqrt(0.1F))});
    EXPECT_EQ(std::max_element(logits.begin(), logits.end()) - logits.begin(),
              static_cast<std::ptrdiff_t>(c));
    EXPECT_GT(logits[c], plain[c]);
  }
  EXPECT_THROW(learner.exciting_input(0, even, 0), core::InputError);
  EXPECT_THROW(learner.exciting_input(0, std::span(even).first(3), 0.1), core::InputError);
  EXPECT_THROW(learner.exciting_input(0, std::vector<float>(even.size(), 0.0F), 0.1),
               core::InputError);
}

TEST(NearestNeighbours, AreThoseOfAllPairsOfDistances) {
  MadeSource source(300, 3, 2.0);
  const learning::LabelledSamples samples = learning::label_samples(source, made_task());
  learning::Method method = svm({learning::Modality::spectrogram, learning::Modality::voxels});
  method.kind = learning::MethodKind::nearest_neighbour;
  method.neighbours = 5;
  const auto rows = samples.rows(learning::Part::test), known = samples.rows(learning::Part::train);
  const auto fractions = networks::ask_neighbours(method, source, samples, rows, {});
  const auto values_of = [&](std::uint32_t row) {
    std::vector<float> values(96 + 1728);
    source.read(learning::Modality::spectrogram, std::vector<std::uint32_t>{row},
                std::span(values).first(96));
    source.read(learning::Modality::voxels, std::vector<std::uint32_t>{row % 3},
                std::span(values).subspan(96));
    return values;
  };
  for (std::size_t i = 0; i < rows.size(); i += 7) {
    const auto own = values_of(rows[i]);
    std::vector<std::pair<double, std::int32_t>> distances;
    for (const std::uint32_t other : known) {
      const auto values = values_of(other);
      double square = 0;
      for (std::size_t v = 0; v < own.size(); ++v) square += std::pow(own[v] - values[v], 2);
      distances.emplace_back(square, samples.label[other]);
    }
    std::sort(distances.begin(), distances.end());
    std::vector<double> expected(3, 0);
    for (int n = 0; n < 5; ++n)
      expected[static_cast<std::size_t>(distances[static_cast<std::size_t>(n)].second)] += 0.2;
    const double maximum = *std::max_element(expected.begin(), expected.end());
    for (const auto& [distance, label] : distances) {
      if (expected[static_cast<std::size_t>(label)] != maximum) continue;
      expected[static_cast<std::size_t>(label)] += 0.1;
      break;
    }
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(fractions[i * 3 + c], expected[c], 1e-5);
  }
}

}  // namespace
}  // namespace carillon::eval
