#include "eval/recognition/recognition.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/json.hpp"
#include "core/random.hpp"
#include "eval/classification/calibration.hpp"
#include "eval/classification/open_set.hpp"
#include "eval/learning/sealed_file.hpp"
#include "synth/recording/noise_generators.hpp"

namespace carillon::eval::recognition {

namespace {

/// Noises of each kind that are tried.
constexpr std::size_t noises = 100;

using Rows = std::vector<std::uint32_t>;

std::vector<std::size_t> labels_of(const learning::LabelledSamples& samples, const Rows& rows) {
  std::vector<std::size_t> labels;
  for (const std::uint32_t row : rows) {
    labels.push_back(static_cast<std::size_t>(samples.label[row]));
  }
  return labels;
}

std::vector<double> doubles(std::span<const float> values) {
  return {values.begin(), values.end()};
}

/// Of logits, rows x classes.
std::vector<double> log_odds(std::span<const float> logits, std::size_t classes,
                             double temperature) {
  if (logits.empty()) return {};
  const std::vector<double> values = doubles(logits);
  return classification::log_odds_scores({values, classes}, temperature);
}

/// Scores, and which of them stand and fall together.
struct Scored {
  std::vector<double> scores;
  std::vector<std::size_t> groups;
};

RecognitionTrial::Unknown against(const Scored& known, const Scored& unknown, double threshold) {
  return {
      unknown.scores.size(), classification::auroc(known.scores, unknown.scores),
      classification::auroc_interval(known.scores, known.groups, unknown.scores, unknown.groups),
      classification::fraction_reaching(unknown.scores, threshold)};
}

std::vector<double> noise_log_odds(const Recognition& recognition, const networks::Learner& learner,
                                   synth::recording::NoiseKind kind, const std::string& name) {
  const learning::ClipPreparer preparer(recognition.format);
  std::vector<double> scores;
  for (std::size_t i = 0; i < noises; ++i) {
    core::RandomStream random(0, i, "recognition." + name);
    const auto noise =
        synth::recording::generate_noise(kind, learning::noise_lengths * recognition.format.samples,
                                         recognition.format.sample_rate(), random);
    const std::vector<float> clip = learning::noise_clip(noise, recognition.format);
    scores.push_back(recognise(learner, recognition, preparer, clip).log_odds);
  }
  return scores;
}

/// Temperature and threshold, from the validation samples' logits.
void learn_sureness(std::span<const float> validation, std::span<const std::size_t> truth,
                    std::size_t classes, Recognition& recognition) {
  recognition.temperature = classification::fit_temperature({doubles(validation), classes}, truth);
  recognition.threshold = classification::threshold_at(
      log_odds(validation, classes, recognition.temperature), accepted_fraction);
}

}  // namespace

Recognition learn_recognition(networks::Learner& learner, learning::SampleSource& source,
                              const learning::LabelledSamples& samples,
                              std::span<const float> validation,
                              const networks::LearningRanks& ranks) {
  Recognition recognition;
  recognition.format = source.clip_format().value();
  const std::size_t classes = samples.classes.size();
  if (validation.empty()) {
    const auto known = learner.predict(source, samples, samples.rows(learning::Part::train), ranks);
    recognition.threshold =
        classification::threshold_at(log_odds(known, classes, 1), accepted_fraction);
  } else {
    learn_sureness(validation, labels_of(samples, samples.rows(learning::Part::validation)),
                   classes, recognition);
  }
  return recognition;
}

double unknown_fraction(std::span<const float> validation, std::span<const std::size_t> truth,
                        std::span<const float> asked, std::size_t classes) {
  Recognition recognition;
  learn_sureness(validation, truth, classes, recognition);
  return 1 - classification::fraction_reaching(log_odds(asked, classes, recognition.temperature),
                                               recognition.threshold);
}

Recognised recognise(const networks::Learner& learner, const Recognition& recognition,
                     const learning::ClipPreparer& preparer, std::span<const float> clip) {
  std::vector<std::vector<float>> modalities;
  bool sounds = false;
  for (const learning::Modality modality : learner.method().modalities) {
    modalities.emplace_back(learning::values_in(preparer.extent(modality)));
    sounds = preparer.prepare(modality, clip, modalities.back()) || sounds;
    if (modality == learning::Modality::spectrogram) {
      learner.method().spectrogram.apply(modalities.back());
    }
  }
  const std::vector<double> logits = doubles(learner.logits_of(modalities));
  Recognised recognised;
  recognised.probabilities =
      classification::softmax({logits, logits.size()}, recognition.temperature);
  recognised.log_odds =
      classification::log_odds_scores({logits, logits.size()}, recognition.temperature).front();
  recognised.known = sounds && recognised.log_odds >= recognition.threshold;
  return recognised;
}

RecognitionTrial try_recognition(const Recognition& recognition, networks::Learner& learner,
                                 learning::SampleSource& source,
                                 const learning::LabelledSamples& samples,
                                 std::span<const float> test,
                                 std::span<const std::size_t> test_groups,
                                 const networks::LearningRanks& ranks) {
  RecognitionTrial trial;
  trial.temperature = recognition.temperature;
  const Rows tested = samples.rows(learning::Part::test);
  const std::vector<double> logits = doubles(test);
  const std::vector<std::size_t> truth = labels_of(samples, tested);
  const std::size_t classes = samples.classes.size();
  trial.calibration_error = trial.uncalibrated_error = trial.calibration_by_chance =
      std::numeric_limits<double>::quiet_NaN();
  if (!tested.empty()) {
    const std::vector<double> calibrated =
        classification::softmax({logits, classes}, recognition.temperature);
    const std::vector<double> uncalibrated = classification::softmax({logits, classes});
    core::RandomStream random(0, 0, "recognition.calibration");
    trial.calibration_error = classification::expected_calibration_error(
        classification::reliability({calibrated, classes}, truth));
    trial.uncalibrated_error = classification::expected_calibration_error(
        classification::reliability({uncalibrated, classes}, truth));
    trial.calibration_by_chance =
        classification::calibration_error_by_chance({calibrated, classes}, test_groups, random);
  }
  const Scored known{log_odds(test, classes, recognition.temperature),
                     {test_groups.begin(), test_groups.end()}};
  trial.accepted = classification::fraction_reaching(known.scores, recognition.threshold);
  Rows others;
  for (std::size_t i = 0; i < samples.label.size(); ++i) {
    if (samples.label[i] == learning::left_out) others.push_back(static_cast<std::uint32_t>(i));
  }
  if (!others.empty()) {
    const std::vector<float> theirs = learner.predict(source, samples, others, ranks);
    Scored unknown{log_odds(theirs, classes, recognition.temperature), {}};
    for (const std::uint32_t row : others) unknown.groups.push_back(samples.object_groups[row]);
    trial.unknown["left_out"] = against(known, unknown, recognition.threshold);
  }
  for (const std::string& name : synth::recording::noise_kind_names()) {
    Scored unknown{noise_log_odds(recognition, learner, synth::recording::noise_kind(name), name),
                   {}};
    unknown.groups.resize(unknown.scores.size());
    std::iota(unknown.groups.begin(), unknown.groups.end(), std::size_t{0});
    trial.unknown[name] = against(known, unknown, recognition.threshold);
  }
  return trial;
}

nlohmann::ordered_json to_json(const RecognitionTrial& trial) {
  nlohmann::ordered_json found = {
      {"temperature", core::number_or_null(trial.temperature)},
      {"calibration_error", core::number_or_null(trial.calibration_error)},
      {"uncalibrated_error", core::number_or_null(trial.uncalibrated_error)},
      {"calibration_by_chance", core::number_or_null(trial.calibration_by_chance)},
      {"accepted", core::number_or_null(trial.accepted)},
      {"unknown", nlohmann::ordered_json::object()}};
  for (const auto& [name, unknown] : trial.unknown) {
    found["unknown"][name] = {
        {"sounds", unknown.sounds},
        {"auroc", core::number_or_null(unknown.auroc)},
        {"auroc95",
         {core::number_or_null(unknown.auroc95.low), core::number_or_null(unknown.auroc95.high)}},
        {"accepted", core::number_or_null(unknown.accepted)}};
  }
  return found;
}

RecognitionTrial trial_from(const nlohmann::json& found) {
  const auto number = [](const nlohmann::json& of, const char* key) {
    return core::number_or_nan(of.at(key));
  };
  RecognitionTrial trial;
  trial.temperature = number(found, "temperature");
  trial.calibration_error = number(found, "calibration_error");
  trial.uncalibrated_error = number(found, "uncalibrated_error");
  trial.calibration_by_chance = number(found, "calibration_by_chance");
  trial.accepted = number(found, "accepted");
  for (const auto& [name, unknown] : found.at("unknown").items()) {
    const nlohmann::json& bounds = unknown.at("auroc95");
    trial.unknown[name] = {
        .sounds = unknown.at("sounds"),
        .auroc = number(unknown, "auroc"),
        .auroc95 = {core::number_or_nan(bounds.at(0)), core::number_or_nan(bounds.at(1))},
        .accepted = number(unknown, "accepted")};
  }
  return trial;
}

void save_recognition(const std::filesystem::path& path, const Recognition& recognition) {
  learning::write_sealed(path, {{{"format", learning::to_json(recognition.format)},
                                 {"temperature", recognition.temperature},
                                 {"threshold", recognition.threshold}},
                                {}});
}

Recognition load_recognition(const std::filesystem::path& path) {
  const learning::SealedFile file = learning::read_sealed(path);
  return {learning::clip_format_from(file.header.at("format")), file.header.at("temperature"),
          file.header.at("threshold")};
}

}  // namespace carillon::eval::recognition
