#include "cli/learn/classification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "cli/learn/answers.hpp"
#include "cli/learn/published_accuracies.hpp"
#include "cli/learn/tables.hpp"
#include "core/error.hpp"

namespace carillon::cli {

using nlohmann::ordered_json;

namespace {

/// One method on one task of one dataset: its classifiers differ by their seed alone.
struct Group {
  std::vector<const TrainedClassifier*> classifiers;
  std::vector<Answers> answers;

  const TrainingJob& job() const { return classifiers.front()->job; }
  const PartAnswers& test() const { return answers.front().test; }
  std::size_t classes() const { return answers.front().classes.size(); }
};

std::vector<Group> grouped(const std::vector<TrainedClassifier>& trained) {
  std::vector<Group> groups;
  for (const TrainedClassifier& one : trained) {
    const bool fits = !groups.empty() && groups.back().classifiers.front()->source == one.source &&
                      groups.back().job().task.name == one.job.task.name &&
                      groups.back().job().method.name == one.job.method.name;
    if (!fits) groups.emplace_back();
    Group& group = groups.back();
    group.classifiers.push_back(&one);
    group.answers.push_back(read_answers(one.job.folder / "answers.h5"));
    if (group.answers.back().test.keys != group.test().keys) {
      throw core::InputError(
          fmt::format("{} answered for other samples than its other seeds", one.job.key),
          "its folder was changed; delete it, and it is trained again");
    }
  }
  return groups;
}

/// Letters as the papers' tables have them.
std::string letters(const eval::Method& method) {
  std::string text;
  for (const eval::Sense sense : method.senses) {
    switch (sense) {
      case eval::Sense::spectrogram:
      case eval::Sense::waveform:
        text += 'A';
        break;
      case eval::Sense::voxels:
        text += 'V';
        break;
      case eval::Sense::image:
        text += 'I';
        break;
      case eval::Sense::touch:
        text += 'T';
        break;
    }
  }
  return text;
}

double mean_of(const Group& group, const std::function<ordered_json(const ordered_json&)>& value) {
  double sum = 0;
  for (const TrainedClassifier* one : group.classifiers) {
    const ordered_json found = value(one->found);
    sum += found.is_number() ? found.get<double>() : NAN;
  }
  return sum / static_cast<double>(group.classifiers.size());
}

ordered_json row_of(const Group& group, const ClassificationSpec& spec,
                    std::span<const LearningSource> sources) {
  const TrainingJob& job = group.job();
  const std::string& dataset = sources[group.classifiers.front()->source].name;
  const std::vector<std::size_t> truth = true_classes(group.test());
  const std::vector<std::size_t> groups = groups_of(group.test(), job.task.split);
  std::vector<std::vector<std::size_t>> predicted;
  for (const Answers& answers : group.answers) {
    predicted.push_back(likely_classes(answers.test, group.classes()));
  }
  eval::Confusion confusion{group.classes(),
                            std::vector<std::size_t>(group.classes() * group.classes(), 0)};
  for (const std::vector<std::size_t>& one : predicted) {
    eval::add(confusion, eval::count_confusion(truth, one, group.classes()));
  }
  std::vector<std::size_t> distinct = groups;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  ordered_json row = {{"dataset", dataset},
                      {"task", job.task.name},
                      {"method", job.method.name},
                      {"senses", letters(job.method)},
                      {"seeds", ordered_json::array()},
                      {"samples", truth.size()},
                      {"groups", distinct.size()},
                      {"classes", group.answers.front().classes}};
  for (const TrainedClassifier* one : group.classifiers) {
    row["seeds"].push_back(one->job.method.learning.seed);
  }
  const eval::TestedSamples tested{truth, groups, group.classes()};
  for (const auto& [name, kind] : {std::pair{"accuracy", eval::AccuracyKind::plain},
                                   std::pair{"balanced_accuracy", eval::AccuracyKind::balanced}}) {
    row[name] = accuracy_summary(tested, predicted, kind, job.inputs);
  }
  row["recalls"] = ordered_json::array();
  for (const double recall : eval::recalls(confusion))
    row["recalls"].push_back(number_or_null(recall));
  row["confusion"] = ordered_json::array();
  for (std::size_t c = 0; c < group.classes(); ++c) {
    const auto first = confusion.counts.begin() + static_cast<std::ptrdiff_t>(c * group.classes());
    row["confusion"].push_back(
        std::vector<std::size_t>(first, first + static_cast<std::ptrdiff_t>(group.classes())));
  }
  row["validation_accuracy"] = number_or_null(mean_of(
      group, [](const ordered_json& found) { return ordered_json(found["validation_accuracy"]); }));
  row["parameters"] = group.classifiers.front()->found.value("parameters", 0);
  row["training_s"] = mean_of(group, [](const ordered_json& found) {
    const ordered_json& timing = found.at("timing");
    return ordered_json(timing.value("training_s", timing.at("seconds").get<double>()));
  });
  row["published"] = nullptr;
  if (const auto of_task = spec.published.find(job.task.name); of_task != spec.published.end()) {
    if (const auto set = of_task->second.find(dataset); set != of_task->second.end()) {
      if (const auto accuracy = published_accuracy(set->second, job.method.name)) {
        row["published"] = {{"set", set->second}, {"accuracy", *accuracy}};
      }
    }
  }
  return row;
}

}  // namespace

ordered_json classification_document(const ClassificationSpec& spec, const std::string& name,
                                     std::span<const LearningSource> sources,
                                     const std::vector<TrainedClassifier>& trained) {
  ordered_json document = {{"name", name}, {"tasks", ordered_json::array()}};
  for (const eval::TaskSpec& task : spec.learning.tasks) {
    document["tasks"].push_back(
        {{"name", task.name},
         {"column", task.column},
         {"split", task.split},
         {"groups_are", task.split == "split_shape" ? "bodies" : "strikes"}});
  }
  document["datasets"] = ordered_json::array();
  for (const LearningSource& source : sources) {
    document["datasets"].push_back({{"name", source.name}, {"folder", source.samples->name()}});
  }
  document["rows"] = ordered_json::array();
  for (const Group& group : grouped(trained)) {
    document["rows"].push_back(row_of(group, spec, sources));
  }
  return document;
}

}  // namespace carillon::cli
