#include "eval/learning/recognition.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/random.hpp"
#include "eval/classification/calibration.hpp"
#include "eval/learning/sealed_file.hpp"
#include "synth/noise_generators.hpp"

namespace carillon::eval {

namespace {

/// Samples that Gaussians are fitted to, and that are left out, at most: more change nothing.
constexpr std::size_t most_rows = 20000;
/// Noises of each kind that are tried.
constexpr std::size_t noises = 100;

using Rows = std::vector<std::uint32_t>;

/// At most so many, evenly.
Rows thinned(const Rows& rows) {
  if (rows.size() <= most_rows) return rows;
  Rows some;
  for (std::size_t i = 0; i < most_rows; ++i) some.push_back(rows[i * rows.size() / most_rows]);
  return some;
}

std::vector<std::size_t> labels_of(const LabelledSamples& samples, const Rows& rows) {
  std::vector<std::size_t> labels;
  for (const std::uint32_t row : rows) {
    labels.push_back(static_cast<std::size_t>(samples.label[row]));
  }
  return labels;
}

std::vector<double> doubles(std::span<const float> values) {
  return {values.begin(), values.end()};
}

/// Familiarity of rows of a source.
std::vector<double> familiarities(const FeatureGaussians& gaussians, Learner& learner,
                                  SampleSource& source, const LabelledSamples& samples,
                                  const Rows& rows, const LearningRanks& ranks) {
  const std::vector<double> features = doubles(learner.features(source, samples, rows, ranks));
  if (rows.empty()) return {};
  return mahalanobis_scores(gaussians, {features, features.size() / rows.size()});
}

RecognitionTrial::Novel against(const std::vector<double>& known, const std::vector<double>& novel,
                                double threshold) {
  return {novel.size(), auroc(known, novel), share_reaching(novel, threshold)};
}

std::vector<double> noise_familiarities(const Recognition& recognition, const Learner& learner,
                                        synth::NoiseKind kind, const std::string& name) {
  const ClipPreparer preparer(recognition.format);
  std::vector<double> scores;
  for (std::size_t i = 0; i < noises; ++i) {
    core::RandomStream random(0, i, "recognition." + name);
    // As a recording would be: longer than the clip, cut where something begins.
    const auto samples = synth::generate_noise(kind, 2 * recognition.format.samples,
                                               recognition.format.sample_rate(), random);
    core::AudioClip recording;
    recording.sample_rate = static_cast<int>(std::lround(recognition.format.sample_rate()));
    recording.samples.assign(samples.begin(), samples.end());
    const std::vector<float> clip = strike_clip(recording, recognition.format);
    scores.push_back(recognise(learner, recognition, preparer, clip).familiarity);
  }
  return scores;
}

std::string bytes_of(const Eigen::MatrixXd& matrix) {
  return {reinterpret_cast<const char*>(matrix.data()),
          static_cast<std::size_t>(matrix.size()) * sizeof(double)};
}

Eigen::MatrixXd matrix_of(const std::string& bytes, Eigen::Index rows) {
  const auto count = static_cast<Eigen::Index>(bytes.size() / sizeof(double));
  Eigen::MatrixXd matrix(rows, rows == 0 ? 0 : count / rows);
  std::memcpy(matrix.data(), bytes.data(),
              static_cast<std::size_t>(matrix.size()) * sizeof(double));
  return matrix;
}

}  // namespace

bool only_hears(const Method& method) {
  return method.kind == MethodKind::network &&
         std::all_of(method.senses.begin(), method.senses.end(), [](Sense sense) {
           return sense == Sense::spectrogram || sense == Sense::waveform;
         });
}

Recognition learn_recognition(Learner& learner, SampleSource& source,
                              const LabelledSamples& samples, std::span<const float> validation,
                              const LearningRanks& ranks) {
  Recognition recognition;
  recognition.format = source.clip_format().value();
  const std::size_t classes = samples.classes.size();
  const Rows train = thinned(samples.rows(Part::train));
  const std::vector<double> features = doubles(learner.features(source, samples, train, ranks));
  recognition.gaussians =
      fit_gaussians({features, features.size() / train.size()}, labels_of(samples, train), classes);
  Rows held_out = samples.rows(Part::validation);
  if (!held_out.empty()) {
    const std::vector<double> logits = doubles(validation);
    recognition.temperature =
        fit_temperature({logits, classes}, labels_of(samples, held_out)).value;
  } else {
    held_out = train;
  }
  const auto known =
      familiarities(recognition.gaussians, learner, source, samples, held_out, ranks);
  recognition.threshold = threshold_at(known, accepted_share);
  return recognition;
}

Recognised recognise(const Learner& learner, const Recognition& recognition,
                     const ClipPreparer& preparer, std::span<const float> clip) {
  std::vector<std::vector<float>> senses;
  bool sounds = false;
  for (const Sense sense : learner.method().senses) {
    senses.emplace_back(values_in(preparer.extent(sense)));
    sounds = preparer.prepare(sense, clip, senses.back()) || sounds;
  }
  const Learner::Look look = learner.look(senses);
  const std::vector<double> logits = doubles(look.logits), features = doubles(look.features);
  Recognised recognised;
  recognised.probabilities = softmax({logits, logits.size()}, recognition.temperature);
  recognised.familiarity =
      mahalanobis_scores(recognition.gaussians, {features, features.size()}).front();
  recognised.known = sounds && recognised.familiarity >= recognition.threshold;
  return recognised;
}

RecognitionTrial try_recognition(const Recognition& recognition, Learner& learner,
                                 SampleSource& source, const LabelledSamples& samples,
                                 std::span<const float> test, const LearningRanks& ranks) {
  RecognitionTrial trial;
  const Rows tested = samples.rows(Part::test);
  const std::vector<double> logits = doubles(test);
  const std::vector<std::size_t> truth = labels_of(samples, tested);
  const auto error = [&](double temperature) {
    if (tested.empty()) return std::numeric_limits<double>::quiet_NaN();
    const ScoreRows rows{logits, samples.classes.size()};
    const std::vector<double> probabilities = softmax(rows, temperature);
    return expected_calibration_error(reliability({probabilities, rows.columns}, truth));
  };
  trial.calibration_error = error(recognition.temperature);
  trial.uncalibrated_error = error(1);
  const auto known = familiarities(recognition.gaussians, learner, source, samples, tested, ranks);
  trial.accepted = share_reaching(known, recognition.threshold);
  Rows others;
  for (std::size_t i = 0; i < samples.label.size(); ++i) {
    if (samples.label[i] == left_out) others.push_back(static_cast<std::uint32_t>(i));
  }
  if (!others.empty()) {
    const auto novel =
        familiarities(recognition.gaussians, learner, source, samples, thinned(others), ranks);
    trial.novel["left_out"] = against(known, novel, recognition.threshold);
  }
  for (const std::string& name : synth::noise_kind_names()) {
    const auto novel = noise_familiarities(recognition, learner, synth::noise_kind(name), name);
    trial.novel[name] = against(known, novel, recognition.threshold);
  }
  return trial;
}

void save_recognition(const std::filesystem::path& path, const Recognition& recognition) {
  const FeatureGaussians& gaussians = recognition.gaussians;
  write_sealed(path, {{{"format", to_json(recognition.format)},
                       {"temperature", recognition.temperature},
                       {"threshold", recognition.threshold},
                       {"features", gaussians.cholesky.rows()},
                       {"shrinkage", gaussians.shrinkage}},
                      {bytes_of(gaussians.cholesky), bytes_of(gaussians.centres)}});
}

Recognition load_recognition(const std::filesystem::path& path) {
  const SealedFile file = read_sealed(path);
  Recognition recognition;
  recognition.format = clip_format_from(file.header.at("format"));
  recognition.temperature = file.header.at("temperature");
  recognition.threshold = file.header.at("threshold");
  const Eigen::Index features = file.header.at("features");
  recognition.gaussians = {matrix_of(file.blocks.at(0), features),
                           matrix_of(file.blocks.at(1), features), file.header.at("shrinkage")};
  return recognition;
}

}  // namespace carillon::eval
