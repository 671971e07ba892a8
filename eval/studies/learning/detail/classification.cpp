#include "eval/studies/learning/detail/classification.hpp"

#include <algorithm>
#include <cmath>

#include "eval/studies/learning/detail/published_accuracies.hpp"

namespace carillon::eval::studies {

namespace {

/// One method on one task of one dataset: its classifiers differ by their seed alone.
struct Group {
  std::vector<const TrainedClassifier*> classifiers;
  std::vector<std::string> classes;
  scoring::SeedAnswers test;

  const TrainingJob& job() const { return classifiers.front()->job; }
  std::size_t source() const { return classifiers.front()->source; }
  bool is_of_same(const TrainedClassifier& other) const {
    return source() == other.source && job().task.name == other.job.task.name;
  }
};

std::vector<Group> grouped(const std::vector<TrainedClassifier>& trained) {
  std::vector<Group> groups;
  for (const TrainedClassifier& one : trained) {
    const scoring::Answers answers = scoring::read_answers(one.job.folder / "answers.h5");
    if (groups.empty() || !groups.back().is_of_same(one) ||
        groups.back().job().method.name != one.job.method.name) {
      groups.push_back({{}, answers.classes, scoring::SeedAnswers(one.job.task.split)});
    }
    groups.back().classifiers.push_back(&one);
    groups.back().test.add(answers.test, answers.classes);
  }
  return groups;
}

std::string letters(const learning::Method& method) {
  std::string text;
  for (const learning::Modality modality : method.modalities) {
    switch (modality) {
      case learning::Modality::spectrogram:
      case learning::Modality::waveform:
        text += 'A';
        break;
      case learning::Modality::voxels:
        text += 'V';
        break;
      case learning::Modality::image:
        text += 'I';
        break;
      case learning::Modality::touch:
        text += 'T';
        break;
    }
  }
  return text;
}

/// Mean over seeds of a number of their trainings; NaN where one lacks it.
template <class Number>
double mean_of(const Group& group, const Number& number_of) {
  double sum = 0;
  for (const TrainedClassifier* one : group.classifiers) sum += number_of(one->record);
  return sum / static_cast<double>(group.classifiers.size());
}

std::optional<recognition::RecognitionTrial> recognition_of(const Group& group) {
  using recognition::RecognitionTrial;
  if (!group.classifiers.front()->record.recognition) return std::nullopt;
  const auto mean = [&](double RecognitionTrial::*number) {
    return mean_of(group, [&](const TrainingRecord& one) { return (*one.recognition).*number; });
  };
  RecognitionTrial found;
  found.calibration_error = mean(&RecognitionTrial::calibration_error);
  found.calibration_by_chance = mean(&RecognitionTrial::calibration_by_chance);
  found.accepted = mean(&RecognitionTrial::accepted);
  for (const auto& [name, first] : group.classifiers.front()->record.recognition->unknown) {
    const auto of_unknown = [&, &name = name](double RecognitionTrial::Unknown::*number) {
      return mean_of(group, [&](const TrainingRecord& one) {
        return one.recognition->unknown.at(name).*number;
      });
    };
    RecognitionTrial::Unknown& unknown = found.unknown[name];
    unknown.auroc = of_unknown(&RecognitionTrial::Unknown::auroc);
    unknown.accepted = of_unknown(&RecognitionTrial::Unknown::accepted);
    unknown.auroc95 = {1, 0};
    for (const TrainedClassifier* one : group.classifiers) {
      const core::Range& bounds = one->record.recognition->unknown.at(name).auroc95;
      if (std::isnan(bounds.low)) continue;
      unknown.auroc95.low = std::min(unknown.auroc95.low, bounds.low);
      unknown.auroc95.high = std::max(unknown.auroc95.high, bounds.high);
    }
    if (unknown.auroc95.low > unknown.auroc95.high) unknown.auroc95 = {core::nan, core::nan};
  }
  return found;
}

std::optional<ClassificationRow::Published> published_of(const ClassificationSpec& spec,
                                                         const ClassificationRow& row) {
  const auto of_task = spec.published.find(row.task);
  if (of_task == spec.published.end()) return std::nullopt;
  const auto set = of_task->second.find(row.dataset);
  if (set == of_task->second.end()) return std::nullopt;
  const auto accuracy = published_accuracy(set->second, row.method);
  if (!accuracy) return std::nullopt;
  return ClassificationRow::Published{set->second, *accuracy};
}

ClassificationRow row_of(const Group& group, const ClassificationSpec& spec,
                         std::span<const LearningSource> sources) {
  const TrainingJob& job = group.job();
  ClassificationRow row;
  row.dataset = sources[group.source()].name;
  row.task = job.task.name;
  row.method = job.method.name;
  row.modalities = letters(job.method);
  for (const TrainedClassifier* one : group.classifiers) {
    row.seeds.push_back(one->job.method.learning.seed);
  }
  row.samples = group.test.samples();
  row.groups = group.test.groups();
  row.classes = group.classes;
  row.accuracy = group.test.summary(classification::AccuracyKind::plain, job.inputs);
  row.balanced_accuracy = group.test.summary(classification::AccuracyKind::balanced, job.inputs);
  row.confusion = group.test.confusion();
  row.validation_accuracy =
      mean_of(group, [](const TrainingRecord& one) { return one.validation_accuracy; });
  if (const auto& learnt = group.classifiers.front()->record.learnt) {
    row.parameters = learnt->parameters;
  }
  row.training_s = mean_of(group, [](const TrainingRecord& one) {
    return one.learnt ? one.learnt->training_s : one.seconds;
  });
  row.recognition = recognition_of(group);
  row.published = published_of(spec, row);
  return row;
}

/// The row of a task and dataset that was best on the validation samples.
std::size_t chosen_among(const std::vector<Group>& groups,
                         const std::vector<ClassificationRow>& rows,
                         const TrainedClassifier& like) {
  const auto accuracy = [&](std::size_t g) {
    return std::isnan(rows[g].validation_accuracy) ? -1.0 : rows[g].validation_accuracy;
  };
  std::size_t best = groups.size();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (!groups[g].is_of_same(like)) continue;
    if (best == groups.size() || accuracy(g) > accuracy(best)) best = g;
  }
  return best;
}

void compare_rows(const std::vector<Group>& groups, std::vector<ClassificationRow>& rows) {
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const std::size_t chosen = chosen_among(groups, rows, *groups[g].classifiers.front());
    rows[g].chosen = g == chosen;
    if (g == chosen) continue;
    rows[g].difference = groups[g].test.less(groups[chosen].test);
    rows[g].difference_from = rows[chosen].method;
  }
}

}  // namespace

Classification find_classification(const ClassificationSpec& spec, const std::string& name,
                                   std::span<const LearningSource> sources,
                                   const std::vector<TrainedClassifier>& trained) {
  Classification found{name, spec.learning.tasks, {}, {}};
  for (const LearningSource& source : sources) {
    found.datasets.push_back({source.name, source.samples->name()});
  }
  const std::vector<Group> groups = grouped(trained);
  for (const Group& group : groups) found.rows.push_back(row_of(group, spec, sources));
  compare_rows(groups, found.rows);
  return found;
}

}  // namespace carillon::eval::studies
