#include "eval/studies/learning/detail/classification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/json.hpp"
#include "eval/studies/learning/detail/published_accuracies.hpp"
#include "eval/studies/learning/detail/seed_answers.hpp"

namespace carillon::eval::studies {

using nlohmann::ordered_json;

namespace {

/// One method on one task of one dataset: its classifiers differ by their seed alone.
struct Group {
  std::vector<const TrainedClassifier*> classifiers;
  std::vector<std::string> classes;
  SeedAnswers test;

  const TrainingJob& job() const { return classifiers.front()->job; }
  std::size_t source() const { return classifiers.front()->source; }
  bool is_of_same(const TrainedClassifier& other) const {
    return source() == other.source && job().task.name == other.job.task.name;
  }
};

std::vector<Group> grouped(const std::vector<TrainedClassifier>& trained) {
  std::vector<Group> groups;
  for (const TrainedClassifier& one : trained) {
    const Answers answers = read_answers(one.job.folder / "answers.h5");
    if (groups.empty() || !groups.back().is_of_same(one) ||
        groups.back().job().method.name != one.job.method.name) {
      groups.push_back({{}, answers.classes, SeedAnswers(one.job.task.split)});
    }
    groups.back().classifiers.push_back(&one);
    groups.back().test.add(answers.test, answers.classes);
  }
  return groups;
}

/// Letters as the papers' tables have them.
std::string letters(const learning::Method& method) {
  std::string text;
  for (const learning::Sense sense : method.senses) {
    switch (sense) {
      case learning::Sense::spectrogram:
      case learning::Sense::waveform:
        text += 'A';
        break;
      case learning::Sense::voxels:
        text += 'V';
        break;
      case learning::Sense::image:
        text += 'I';
        break;
      case learning::Sense::touch:
        text += 'T';
        break;
    }
  }
  return text;
}

/// Mean over seeds of a number of their trainings; null where one lacks it.
ordered_json mean_of(const Group& group, const ordered_json::json_pointer& place) {
  double sum = 0;
  for (const TrainedClassifier* one : group.classifiers) {
    const bool known = one->found.contains(place) && one->found.at(place).is_number();
    sum += known ? one->found.at(place).get<double>() : NAN;
  }
  return core::number_or_null(sum / static_cast<double>(group.classifiers.size()));
}

/// How sure the classifiers that only hear are, and of what they are not: means over seeds; of an
/// area's intervals the lowest and the highest end.
ordered_json recognition_of(const Group& group) {
  const ordered_json& first = group.classifiers.front()->found;
  if (!first.contains("recognition")) return nullptr;
  const ordered_json::json_pointer all("/recognition");
  ordered_json found = {{"calibration_error", mean_of(group, all / "calibration_error")},
                        {"calibration_by_chance", mean_of(group, all / "calibration_by_chance")},
                        {"accepted", mean_of(group, all / "accepted")},
                        {"novel", ordered_json::object()}};
  for (const auto& [name, novel] : first["recognition"]["novel"].items()) {
    const auto place = all / "novel" / name;
    double low = 1, high = 0;
    for (const TrainedClassifier* one : group.classifiers) {
      const ordered_json& bounds = one->found.at(place / "auroc95");
      if (bounds.at(0).is_null()) continue;
      low = std::min(low, bounds.at(0).get<double>());
      high = std::max(high, bounds.at(1).get<double>());
    }
    found["novel"][name] = {{"auroc", mean_of(group, place / "auroc")},
                            {"auroc95",
                             {core::number_or_null(low > high ? NAN : low),
                              core::number_or_null(low > high ? NAN : high)}},
                            {"accepted", mean_of(group, place / "accepted")}};
  }
  return found;
}

ordered_json row_of(const Group& group, const ClassificationSpec& spec,
                    std::span<const LearningSource> sources) {
  const TrainingJob& job = group.job();
  const std::string& dataset = sources[group.source()].name;
  ordered_json row = {{"dataset", dataset},
                      {"task", job.task.name},
                      {"method", job.method.name},
                      {"senses", letters(job.method)},
                      {"seeds", ordered_json::array()},
                      {"samples", group.test.samples()},
                      {"groups", group.test.groups()},
                      {"classes", group.classes}};
  for (const TrainedClassifier* one : group.classifiers) {
    row["seeds"].push_back(one->job.method.learning.seed);
  }
  row["accuracy"] = group.test.summary(classification::AccuracyKind::plain, job.inputs);
  row["balanced_accuracy"] = group.test.summary(classification::AccuracyKind::balanced, job.inputs);
  const classification::Confusion& confusion = group.test.confusion();
  row["recalls"] = ordered_json::array();
  for (const double recall : classification::recalls(confusion)) {
    row["recalls"].emplace_back(core::number_or_null(recall));
  }
  row["confusion"] = ordered_json::array();
  for (std::size_t c = 0; c < confusion.classes; ++c) {
    const auto first =
        confusion.counts.begin() + static_cast<std::ptrdiff_t>(c * confusion.classes);
    row["confusion"].push_back(
        std::vector<std::size_t>(first, first + static_cast<std::ptrdiff_t>(confusion.classes)));
  }
  const ordered_json& found = group.classifiers.front()->found;
  const bool learns = found.contains("parameters");
  const ordered_json::json_pointer timing("/timing");
  row["validation_accuracy"] = mean_of(group, ordered_json::json_pointer("/validation_accuracy"));
  row["parameters"] = learns ? found["parameters"] : ordered_json(0);
  row["training_s"] = mean_of(group, timing / (learns ? "training_s" : "seconds"));
  row["recognition"] = recognition_of(group);
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

/// The row of a task and dataset that was best on the validation samples, which alone may choose.
std::size_t chosen_among(const std::vector<Group>& groups, const ordered_json& rows,
                         const TrainedClassifier& like) {
  const auto accuracy = [&](std::size_t g) {
    const ordered_json& found = rows.at(g).at("validation_accuracy");
    return found.is_number() ? found.get<double>() : -1.0;
  };
  std::size_t best = groups.size();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (!groups[g].is_of_same(like)) continue;
    if (best == groups.size() || accuracy(g) > accuracy(best)) best = g;
  }
  return best;
}

/// `chosen`, and how each other row differs from the chosen one on the same samples.
void compare_rows(const std::vector<Group>& groups, ordered_json& rows) {
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const std::size_t chosen = chosen_among(groups, rows, *groups[g].classifiers.front());
    rows[g]["chosen"] = g == chosen;
    rows[g]["difference"] = nullptr;
    if (g == chosen || groups[g].test.empty()) continue;
    rows[g]["difference"] = groups[g].test.less(groups[chosen].test);
    rows[g]["difference"]["from"] = rows[chosen]["method"];
  }
}

}  // namespace

ordered_json classification_document(const ClassificationSpec& spec, const std::string& name,
                                     std::span<const LearningSource> sources,
                                     const std::vector<TrainedClassifier>& trained) {
  ordered_json document = {{"name", name}, {"tasks", ordered_json::array()}};
  for (const learning::TaskSpec& task : spec.learning.tasks) {
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
  const std::vector<Group> groups = grouped(trained);
  for (const Group& group : groups) document["rows"].push_back(row_of(group, spec, sources));
  compare_rows(groups, document["rows"]);
  return document;
}

}  // namespace carillon::eval::studies
