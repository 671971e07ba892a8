#include "eval/studies/learning/detail/spectrograms.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/config.hpp"
#include "core/random.hpp"
#include "eval/statistics/principal_components.hpp"
#include "mpi/comm.hpp"

namespace carillon::eval::studies {

using core::ConfigNode;

namespace {

constexpr std::size_t components = 2;
/// Filters whose activations are shown (Sterling 2019, Fig. 6.6).
constexpr std::size_t shown_filters = 5;

bool sees_spectrograms_alone(const learning::Method& method) {
  return method.kind == learning::MethodKind::network && method.branches.size() == 1 &&
         method.modalities.front() == learning::Modality::spectrogram;
}

/// To four digits after the point, as pictures are kept.
template <class Number>
std::vector<double> rounded(std::span<const Number> values) {
  std::vector<double> numbers;
  for (const double value : values) numbers.push_back(std::round(1e4 * value) / 1e4);
  return numbers;
}

/// So many rows, ascending, whatever the order of objects, materials and strikes.
std::vector<std::uint32_t> some_rows(const std::vector<std::string>& keys, std::size_t count) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  for (std::uint32_t row = 0; row < keys.size(); ++row) {
    order.emplace_back(core::stable_hash("spectrogram " + keys[row]), row);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::uint32_t> rows;
  for (std::size_t i = 0; i < count; ++i) rows.push_back(order[i].second);
  std::sort(rows.begin(), rows.end());
  return rows;
}

/// @return the sounds' rows
std::vector<std::uint32_t> find_components(const SpectrogramStudy& study,
                                           learning::SampleSource& source,
                                           DatasetSpectrograms& dataset) {
  const learning::ModalityLayout layout =
      learning::require_layout(source, learning::Modality::spectrogram);
  const std::size_t each = learning::values_in(layout.extent);
  const std::size_t count = std::min(study.sounds, source.size());
  std::vector<float> read(each);
  std::vector<double> values;
  const std::vector<std::string> all_labels = source.labels(study.color);
  const std::vector<std::string> all_keys = source.keys();
  const std::vector<std::uint32_t> rows = some_rows(all_keys, count);
  for (const std::uint32_t row : rows) {
    source.read(learning::Modality::spectrogram, {&row, 1}, read);
    study.method.spectrogram.apply(read);
    values.insert(values.end(), read.begin(), read.end());
    dataset.labels.push_back(all_labels[row]);
    dataset.keys.push_back(all_keys[row]);
  }
  const statistics::PrincipalComponents found =
      statistics::principal_components(values, each, components);
  std::map<std::string, std::size_t> numbers;
  for (const std::string& label : dataset.labels) numbers.emplace(label, numbers.size());
  std::vector<std::size_t> groups;
  for (const std::string& label : dataset.labels) groups.push_back(numbers.at(label));
  for (const double value : values)
    dataset.mean_square += value * value / static_cast<double>(values.size());
  dataset.bands = static_cast<std::size_t>(layout.extent[1]);
  if (const std::optional<learning::ClipFormat> format = source.clip_format()) {
    dataset.band_hz = synth::signal::mel_band_centers(format->mel);
    dataset.frame_s = synth::signal::mel_frame_centers(format->samples, format->mel);
  }
  dataset.mean = rounded(std::span(found.mean));
  for (std::size_t k = 0; k < found.fractions.size(); ++k) {
    std::vector<double> along;
    for (std::size_t i = 0; i < count; ++i) {
      along.push_back(found.coordinates[i * found.fractions.size() + k]);
    }
    const double explained = statistics::explained_by_groups(along, groups);
    dataset.components.push_back({found.fractions[k], explained,
                                  rounded(std::span(found.components).subspan(k * each, each)),
                                  std::move(along)});
  }
  return rows;
}

/// Number of the sound nearest to the mean along the components.
std::size_t middle_sound(const DatasetSpectrograms& dataset) {
  const auto away = [&](std::size_t sound) {
    double square = 0;
    for (const DatasetSpectrograms::Component& component : dataset.components)
      square += component.coordinates[sound] * component.coordinates[sound];
    return square;
  };
  std::size_t middle = 0;
  for (std::size_t i = 1; i < dataset.keys.size(); ++i)
    if (away(i) < away(middle)) middle = i;
  return middle;
}

/// The filter with the largest activations, then always the one least alike to those chosen, of
/// those excited a tenth as much.
std::vector<std::size_t> unlike_filters(const networks::Learner::Activations& of) {
  const auto cells = static_cast<Eigen::Index>(of.bands * of.frames);
  const Eigen::Map<const Eigen::MatrixXf> values(of.values.data(), cells,
                                                 static_cast<Eigen::Index>(of.filters));
  const Eigen::VectorXf strength = values.colwise().norm();
  Eigen::Index strongest = 0;
  const float largest = strength.maxCoeff(&strongest);
  std::vector<std::size_t> chosen;
  Eigen::VectorXf alike = Eigen::VectorXf::Zero(strength.size());  // largest cosine to the chosen
  for (Eigen::Index next = strongest; next >= 0 && largest > 0 && chosen.size() < shown_filters;) {
    chosen.push_back(static_cast<std::size_t>(next));
    const Eigen::VectorXf direction = values.col(next) / strength[next];
    alike[next] = 2;
    next = -1;
    for (Eigen::Index i = 0; i < strength.size(); ++i) {
      if (alike[i] > 1 || strength[i] < largest / 10) continue;
      alike[i] = std::max(alike[i], std::min(1.0F, values.col(i).dot(direction) / strength[i]));
      if (next < 0 || alike[i] < alike[next]) next = i;
    }
  }
  return chosen;
}

/// @param rows  of the dataset's sounds
void find_activations(const networks::Learner& learner, const SpectrogramStudy& study,
                      learning::SampleSource& source, const std::vector<std::uint32_t>& rows,
                      DatasetSpectrograms& dataset) {
  DatasetSpectrograms::Activations& found = dataset.activations;
  found.sound = middle_sound(dataset);
  const std::uint32_t row = rows[found.sound];
  std::vector<float> read(dataset.mean.size());
  source.read(learning::Modality::spectrogram, {&row, 1}, read);
  study.method.spectrogram.apply(read);
  found.spectrogram = rounded(std::span<const float>(read));
  const networks::Learner::Activations all = learner.first_activations(read);
  found.bands = all.bands;
  const std::size_t cells = all.bands * all.frames;
  for (const std::size_t filter : unlike_filters(all)) {
    found.filters.push_back(
        {filter, rounded(std::span(all.values).subspan(filter * cells, cells))});
  }
}

void find_exciting(const networks::Learner& learner, DatasetSpectrograms& dataset) {
  const std::vector<float> mean(dataset.mean.begin(), dataset.mean.end());
  for (std::size_t c = 0; c < learner.classes().size(); ++c) {
    const std::vector<float> input = learner.exciting_input(c, mean, dataset.mean_square);
    dataset.exciting.push_back({learner.classes()[c], rounded(std::span(input))});
  }
}

}  // namespace

SpectrogramStudy read_spectrogram_study(ConfigNode& node, ConfigNode& root,
                                        const std::string& file) {
  SpectrogramStudy study;
  study.learning = read_train_section(root, file);
  std::vector<std::string> tasks, methods;
  for (const learning::TaskSpec& task : study.learning.tasks) tasks.push_back(task.name);
  for (const learning::Method& method : study.learning.methods) {
    if (sees_spectrograms_alone(method)) methods.push_back(method.name);
  }
  if (methods.empty()) {
    node.fail("", "train.methods has no network on spectrograms alone", "for example isnn-a: {}");
  }
  const std::string task = node.choice("task", tasks, tasks.front());
  const std::string method = node.choice("method", methods, methods.front());
  study.task = *std::find_if(study.learning.tasks.begin(), study.learning.tasks.end(),
                             [&](const learning::TaskSpec& one) { return one.name == task; });
  study.method = *std::find_if(study.learning.methods.begin(), study.learning.methods.end(),
                               [&](const learning::Method& one) { return one.name == method; });
  study.color = node.text("color", "material");
  study.sounds = static_cast<std::size_t>(node.integer("max_sounds", 3, 5000, 420));
  return study;
}

std::optional<std::vector<DatasetSpectrograms>> study_spectrograms(
    const SpectrogramStudy& study, const EvaluatedDatasets& datasets, MPI_Comm world) {
  LearningConfig alone = study.learning;
  alone.tasks = {study.task};
  alone.methods = {study.method};
  const auto sources = open_learning_sources(alone, datasets, world);
  mpi::agreed(world, [&] {
    for (const LearningSource& source : sources) source.samples->labels(study.color);
  });
  const std::uint64_t seeds[] = {study.method.learning.seed};
  const TrainingsEnd end = run_trainings(alone, seeds, sources, models_folder(datasets), world);
  if (end.interrupted) return std::nullopt;
  std::vector<DatasetSpectrograms> found;
  mpi::agreed(world, [&] {
    if (mpi::rank(world) != 0) return;
    for (const TrainedClassifier& trained : end.trained) {
      const LearningSource& source = sources[trained.source];
      DatasetSpectrograms& dataset = found.emplace_back();
      dataset.name = source.name;
      const std::vector<std::uint32_t> rows = find_components(study, *source.samples, dataset);
      const networks::Learner learner = networks::Learner::load(trained.job.folder / "model");
      find_activations(learner, study, *source.samples, rows, dataset);
      find_exciting(learner, dataset);
    }
  });
  return found;
}

}  // namespace carillon::eval::studies
