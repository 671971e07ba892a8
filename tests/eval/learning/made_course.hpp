#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "eval/networks/training.hpp"
#include "tests/eval/learning/made_source.hpp"

namespace carillon::eval {

inline std::vector<learning::ModalityExtent> extents_of(const learning::Method& method,
                                                        const learning::SampleSource& source) {
  std::vector<learning::ModalityExtent> extents;
  for (const learning::Modality modality : method.modalities)
    extents.push_back(learning::require_layout(source, modality).extent);
  return extents;
}

inline double accuracy_of(const std::vector<float>& scores, const std::vector<std::uint32_t>& rows,
                          const learning::LabelledSamples& samples) {
  const std::size_t classes = samples.classes.size();
  std::size_t right = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto first = scores.begin() + static_cast<std::ptrdiff_t>(i * classes);
    if (std::max_element(first, first + static_cast<std::ptrdiff_t>(classes)) - first ==
        samples.label[rows[i]]) {
      ++right;
    }
  }
  return static_cast<double>(right) / static_cast<double>(rows.size());
}

struct Course {
  networks::Trained trained;
  std::vector<float> scores;
  double test_accuracy = 0;
};

inline Course train(const learning::Method& method, MadeSource& source,
                    const networks::Checkpoint& checkpoint = {},
                    const networks::LearningWatch& watch = {}) {
  const learning::LabelledSamples samples = learning::label_samples(source, made_task());
  networks::Learner learner(method, extents_of(method, source), samples.classes);
  Course run;
  run.trained = learner.train(source, samples, {}, checkpoint, watch);
  const auto rows = samples.rows(learning::Part::test);
  run.scores = learner.predict(source, samples, rows, {});
  run.test_accuracy = accuracy_of(run.scores, rows, samples);
  return run;
}

}  // namespace carillon::eval
