// Single sounds: right confidences, and what is unlike the training samples.
#include "eval/recognition/recognition.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "core/random.hpp"
#include "core/temporary_folder.hpp"
#include "eval/learning/recordings_source.hpp"

namespace carillon::eval {
namespace {

/// Bars of three lengths: free-free modes (1 : 2.757 : 5.404), decays that go with them.
core::AudioClip bar(std::size_t length, core::RandomStream& random) {
  core::AudioClip clip;
  clip.sample_rate = 22050;
  const double base = (500 + 250 * static_cast<double>(length)) * random.uniform(0.95, 1.05);
  const double amplitudes[] = {random.uniform(0.3, 1), random.uniform(0.3, 1),
                               random.uniform(0.3, 1)};
  for (int i = 0; i < 8000; ++i) {
    const double t = i / 22050.0;
    double value = 0;
    for (int m = 0; m < 3; ++m) {
      const double f = base * (m == 0 ? 1 : m == 1 ? 2.757 : 5.404);
      value +=
          amplitudes[m] * std::exp(-(8 + f / 200) * t) * std::sin(2 * std::numbers::pi * f * t);
    }
    clip.samples.push_back(static_cast<float>(0.1 * value));
  }
  return clip;
}

class Recognising : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<core::TemporaryFolder>();
    for (std::size_t i = 0; i < 180; ++i) {
      core::RandomStream random(3, i, "bars");
      core::write_wav(
          folder_->path() / ("bar" + std::to_string(i % 3) + "-" + std::to_string(i) + ".wav"),
          bar(i % 3, random), core::SampleFormat::float32);
    }
    learning::RecordingsSpec spec;
    spec.folder = folder_->path();
    spec.names = "{shape}-*";
    spec.seconds = 0.3;
    spec.sample_rate = 22050;
    spec.validation = 0.25;
    spec.test = 0.25;
    source_ = learning::open_recordings(spec);
    learning::TaskSpec task;
    task.column = "shape";
    task.split = "split_strike";
    samples_ = learning::label_samples(*source_, task);
    learning::Method method;
    method.branches = {learning::Branch::isnn};
    method.modalities = {learning::Modality::spectrogram};
    method.sizes.layers.front().filters = 8;
    method.sizes.width = 32;
    method.learning.epochs = 15;
    method.learning.batch = 16;  // noises are told apart after some hundred steps
    method.learning.learning_rate = 0.003;
    learner_ = std::make_unique<networks::Learner>(
        method,
        std::vector<learning::ModalityExtent>{
            source_->layout(learning::Modality::spectrogram)->extent},
        samples_.classes);
    learner_->train(*source_, samples_, {}, {}, {});
    recognition_ = recognition::learn_recognition(
        *learner_, *source_, samples_,
        learner_->predict(*source_, samples_, samples_.rows(learning::Part::validation), {}), {});
  }
  static void TearDownTestSuite() {
    learner_.reset();
    source_.reset();
    folder_.reset();
  }
  static recognition::Recognised ask(const core::AudioClip& clip) {
    return recognition::recognise(*learner_, recognition_,
                                  learning::ClipPreparer(recognition_.format),
                                  learning::strike_clip(clip, recognition_.format));
  }

  inline static std::unique_ptr<core::TemporaryFolder> folder_;
  inline static std::unique_ptr<learning::SampleSource> source_;
  inline static learning::LabelledSamples samples_;
  inline static std::unique_ptr<networks::Learner> learner_;
  inline static recognition::Recognition recognition_;
};

TEST_F(Recognising, KnowsNewSoundsOfItsClasses) {
  std::size_t right = 0, known = 0;
  for (std::size_t i = 0; i < 60; ++i) {
    core::RandomStream random(4, i, "other bars");
    const recognition::Recognised answer = ask(bar(i % 3, random));
    EXPECT_NEAR(std::accumulate(answer.probabilities.begin(), answer.probabilities.end(), 0.0), 1,
                1e-9);
    const auto best = std::max_element(answer.probabilities.begin(), answer.probabilities.end());
    right += static_cast<std::size_t>(best - answer.probabilities.begin()) == i % 3 ? 1 : 0;
    known += answer.known ? 1 : 0;
  }
  EXPECT_GT(right, 54U);
  EXPECT_GT(known, 48U);  // 95 % of validation samples are
}

TEST_F(Recognising, TellsNoiseFromItsClasses) {
  const std::vector<std::uint32_t> tested = samples_.rows(learning::Part::test);
  const recognition::RecognitionTrial trial =
      recognition::try_recognition(recognition_, *learner_, *source_, samples_,
                                   learner_->predict(*source_, samples_, tested, {}),
                                   std::vector<std::size_t>(tested.begin(), tested.end()), {});
  ASSERT_EQ(trial.unknown.size(), 5U);  // nothing is left out: noises alone
  for (const auto& [name, unknown] : trial.unknown) {
    EXPECT_GT(unknown.auroc, 0.9) << name;
    EXPECT_LE(unknown.auroc95.low, unknown.auroc);
    EXPECT_GE(unknown.auroc95.high, unknown.auroc);
  }
  EXPECT_GE(trial.calibration_error, 0);
  EXPECT_LT(trial.calibration_error, 0.15);  // 45 samples
  EXPECT_GT(trial.accepted, 0.75);
}

TEST_F(Recognising, AnswersAlikeAfterItWasKept) {
  core::RandomStream random(5, 0, "bars");
  const core::AudioClip clip = bar(1, random);
  const recognition::Recognised before = ask(clip);
  const auto path = folder_->path() / "recognition";
  recognition::save_recognition(path, recognition_);
  const recognition::Recognition kept = recognition::load_recognition(path);
  const recognition::Recognised after =
      recognition::recognise(*learner_, kept, learning::ClipPreparer(kept.format),
                             learning::strike_clip(clip, kept.format));
  EXPECT_EQ(after.probabilities, before.probabilities);
  EXPECT_EQ(after.log_odds, before.log_odds);
  EXPECT_EQ(kept.threshold, recognition_.threshold);
}

TEST_F(Recognising, SilenceIsNoneOfTheClasses) {
  core::AudioClip silence;
  silence.samples.assign(8000, 0.0F);
  const recognition::Recognised answer = ask(silence);
  EXPECT_TRUE(std::isfinite(answer.log_odds));
  EXPECT_FALSE(answer.known);
  for (const double p : answer.probabilities) EXPECT_TRUE(std::isfinite(p));
}

}  // namespace
}  // namespace carillon::eval
