// Samples and files that break training, and what becomes of each.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"
#include "eval/classification/open_set.hpp"
#include "tests/eval/learning/made_course.hpp"

namespace carillon::eval {
namespace {

TEST(LearningHard, AClassOfOneSampleAndNoneToValidateWith) {
  MadeSource source(120, 3);
  source.columns["split"] = std::vector<std::string>(120, "train");
  source.columns["label"] = source.labels("label");
  source.columns["label"][7] = "alone";
  for (std::size_t i = 90; i < 120; ++i) source.columns["split"][i] = "test";
  learning::Method method = made_method({learning::Branch::isnn});
  const Course run = train(method, source);
  EXPECT_EQ(run.trained.best, 8);
  EXPECT_TRUE(std::isnan(run.trained.epochs[0].validation_loss));
  EXPECT_GT(run.test_accuracy, 0.9);
  const std::vector<std::string> said =
      learning::remarks(learning::label_samples(source, made_task()));
  ASSERT_EQ(said.size(), 2U);
  EXPECT_NE(said[0].find("alone not tested"), std::string::npos) << said[0];
  EXPECT_NE(said[1].find("no sample in validation"), std::string::npos) << said[1];
}

TEST(LearningHard, NaNInAFeature) {
  MadeSource source(300, 3);
  learning::Method method = made_method({learning::Branch::isnn});
  method.learning.epochs = 1;
  source.silent = 0;
  EXPECT_EQ(train(method, source).trained.silent, 1u);
  source.not_finite = 30;
  try {
    train(method, source);
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("sample-30"), std::string::npos);
  }
}

TEST(LearningHard, ALossThatIsNoNumber) {
  MadeSource source(300, 3);
  learning::Method method = made_method({learning::Branch::isnn});
  method.learning.learning_rate = 1e30;
  EXPECT_THROW(train(method, source), core::InputError);
}

TEST(LearningHard, ACheckpointCutShort) {
  const core::TemporaryFolder folder;
  const networks::Checkpoint checkpoint{folder.path() / "checkpoint", "inputs"};
  MadeSource source(300, 3);
  learning::Method method = made_method({learning::Branch::isnn});
  method.learning.epochs = 2;
  const Course whole = train(method, source, checkpoint);
  const std::string bytes = core::read_file(checkpoint.file);
  std::ofstream(checkpoint.file, std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  const Course anew = train(method, source, checkpoint);
  EXPECT_EQ(anew.trained.resumed, 0);
  ASSERT_EQ(anew.trained.remarks.size(), whole.trained.remarks.size() + 1);
  EXPECT_NE(anew.trained.remarks[0].find("cut short"), std::string::npos);
  EXPECT_EQ(anew.scores, whole.scores);
  const Course other = train(method, source, {checkpoint.file, "other inputs"});
  EXPECT_EQ(other.trained.resumed, 0);
}

TEST(LearningHard, AllClipsSilent) {
  MadeSource source(120, 3);
  source.all_silent = true;
  const learning::LabelledSamples samples = learning::label_samples(source, made_task());
  learning::Method method = made_method({learning::Branch::isnn});
  networks::Learner learner(method, extents_of(method, source), samples.classes);
  const networks::Trained trained = learner.train(source, samples, {}, {}, {});
  const auto rows = samples.rows(learning::Part::train);
  EXPECT_EQ(trained.silent, rows.size());
  for (const learning::Epoch& epoch : trained.epochs) EXPECT_TRUE(std::isfinite(epoch.train_loss));
  const std::vector<float> scores = learner.predict(source, samples, rows, {});
  for (const float score : scores) EXPECT_TRUE(std::isfinite(score));
}

TEST(LearningHard, AModalityThatIsMissing) {
  MadeSource source(120, 3);
  const learning::Method method = made_method({learning::Branch::isnn, learning::Branch::touch});
  try {
    train(method, source);
    FAIL() << "it was trained without touch";
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("made has no touch"), std::string::npos) << error.message();
    EXPECT_FALSE(error.hint().empty());
  }
}

TEST(LearningHard, LabelsInAnotherOrder) {
  MadeSource source(120, 3), turned(120, 3);
  // The same samples by other names, whose order is the opposite.
  std::vector<std::string> names = source.labels("label");
  for (std::string& name : names) name = std::string(1, static_cast<char>('z' - name.back()));
  turned.columns["label"] = names;
  learning::Method method = made_method({learning::Branch::isnn});
  method.learning.epochs = 30;
  const Course first = train(method, source), second = train(method, turned);
  EXPECT_GT(first.test_accuracy, 0.9);
  EXPECT_GT(second.test_accuracy, 0.9);
  const learning::LabelledSamples a = learning::label_samples(source, made_task()),
                                  b = learning::label_samples(turned, made_task());
  for (std::size_t i = 0; i < a.label.size(); ++i) EXPECT_EQ(b.label[i], 2 - a.label[i]);
}

}  // namespace
}  // namespace carillon::eval
