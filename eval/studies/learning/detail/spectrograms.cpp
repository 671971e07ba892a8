#include "eval/studies/learning/detail/spectrograms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/config.hpp"
#include "core/json.hpp"
#include "core/random.hpp"
#include "eval/statistics/principal_components.hpp"
#include "mpi/comm.hpp"

namespace carillon::eval::studies {

using core::ConfigNode;
using nlohmann::ordered_json;

namespace {

constexpr std::size_t components = 2;

bool sees_spectrograms_alone(const learning::Method& method) {
  return method.kind == learning::MethodKind::network && method.branches.size() == 1 &&
         method.senses.front() == learning::Sense::spectrogram;
}

/// Bands x frames, as lists.
ordered_json picture(std::span<const double> values, const learning::SenseExtent& extent) {
  ordered_json rows = ordered_json::array();
  const auto frames = static_cast<std::size_t>(extent[2]);
  for (std::size_t band = 0; band * frames < values.size(); ++band) {
    ordered_json row = ordered_json::array();
    for (const double value : values.subspan(band * frames, frames)) {
      row.push_back(std::round(1e4 * value) / 1e4);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

/// So many rows, ascending, whatever the order of bodies, materials and strikes.
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

ordered_json find_components(const SpectrogramStudy& study, learning::SampleSource& source) {
  const learning::SenseLayout layout =
      learning::require_layout(source, learning::Sense::spectrogram);
  const std::size_t each = learning::values_in(layout.extent);
  const std::size_t count = std::min(study.sounds, source.size());
  std::vector<float> read(each);
  std::vector<double> values;
  const std::vector<std::string> all_labels = source.labels(study.color);
  const std::vector<std::string> all_keys = source.keys();
  std::vector<std::string> labels, keys;
  for (const std::uint32_t row : some_rows(all_keys, count)) {
    source.read(learning::Sense::spectrogram, {&row, 1}, read);
    values.insert(values.end(), read.begin(), read.end());
    labels.push_back(all_labels[row]);
    keys.push_back(all_keys[row]);
  }
  const statistics::PrincipalComponents found =
      statistics::principal_components(values, each, components);
  std::map<std::string, std::size_t> numbers;
  for (const std::string& label : labels) numbers.emplace(label, numbers.size());
  std::vector<std::size_t> groups;
  for (const std::string& label : labels) groups.push_back(numbers.at(label));
  double mean_square = 0;
  for (const double value : values)
    mean_square += value * value / static_cast<double>(values.size());
  ordered_json document = {{"sounds", count},
                           {"color", study.color},
                           {"keys", keys},
                           {"labels", labels},
                           {"mean", picture(found.mean, layout.extent)},
                           {"mean_square", mean_square},
                           {"components", ordered_json::array()}};
  for (std::size_t k = 0; k < found.fractions.size(); ++k) {
    std::vector<double> along;
    for (std::size_t i = 0; i < count; ++i) {
      along.push_back(found.coordinates[i * found.fractions.size() + k]);
    }
    document["components"].push_back(
        {{"fraction", found.fractions[k]},
         {"explained_by_labels",
          core::number_or_null(statistics::explained_by_groups(along, groups))},
         {"picture", picture(std::span(found.components).subspan(k * each, each), layout.extent)},
         {"coordinates", along}});
  }
  return document;
}

ordered_json find_exciting(const TrainedClassifier& trained, const learning::SampleSource& source,
                           const ordered_json& found) {
  nlohmann::json notes;
  const networks::Learner learner = networks::Learner::load(trained.job.folder / "model", notes);
  const learning::SenseExtent extent =
      learning::require_layout(source, learning::Sense::spectrogram).extent;
  std::vector<float> mean;
  for (const ordered_json& band : found.at("mean")) {
    for (const ordered_json& value : band) mean.push_back(value.get<float>());
  }
  ordered_json classes = ordered_json::array();
  for (std::size_t c = 0; c < learner.classes().size(); ++c) {
    const std::vector<float> input =
        learner.exciting_input(c, mean, found.at("mean_square").get<double>());
    const std::vector<double> values(input.begin(), input.end());
    classes.push_back({{"class", learner.classes()[c]}, {"picture", picture(values, extent)}});
  }
  return classes;
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
  study.sounds = static_cast<std::size_t>(node.integer("sounds", 3, 5000, 420));
  return study;
}

std::optional<ordered_json> study_spectrograms(const SpectrogramStudy& study,
                                               const EvaluatedDatasets& datasets,
                                               const mpi::Context& context) {
  LearningConfig alone = study.learning;
  alone.tasks = {study.task};
  alone.methods = {study.method};
  const auto sources = open_learning_sources(alone, datasets, context);
  mpi::agreed(context.world, [&] {
    for (const LearningSource& source : sources) source.samples->labels(study.color);
  });
  const std::uint64_t seeds[] = {study.method.learning.seed};
  const TrainingsEnd end = run_trainings(alone, seeds, sources, models_folder(datasets), context);
  if (end.interrupted) return std::nullopt;
  ordered_json document = {{"name", datasets.name()},
                           {"task", study.task.name},
                           {"method", study.method.name},
                           {"datasets", ordered_json::array()}};
  for (const TrainedClassifier& trained : end.trained) {
    const LearningSource& source = sources[trained.source];
    mpi::agreed(context.world, [&] {
      if (!context.speaks()) return;
      const ordered_json components_found = find_components(study, *source.samples);
      document["datasets"].push_back(
          {{"name", source.name},
           {"components", components_found},
           {"exciting", find_exciting(trained, *source.samples, components_found)}});
    });
  }
  return document;
}

}  // namespace carillon::eval::studies
