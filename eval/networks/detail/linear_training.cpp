#include "eval/networks/detail/linear_training.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/random.hpp"
#include "core/trace.hpp"
#include "eval/networks/detail/linear_machine.hpp"

namespace carillon::eval::networks {

namespace {

/// Samples that are read at a time.
constexpr std::size_t read_batch = 256;

/// As many rows as fit into the memory, drawn evenly from all; says so where they are fewer.
std::vector<std::uint32_t> fitting_rows(std::vector<std::uint32_t> rows, double memory,
                                        std::size_t values, std::uint64_t seed,
                                        std::vector<std::string>& remarks) {
  const auto fitting =
      static_cast<std::size_t>(std::max(1.0, memory / LinearSamples::bytes_of(values)));
  if (fitting >= rows.size()) return rows;
  remarks.push_back(
      fmt::format("learns from {} of {} samples, which fill `memory`: more of it takes all",
                  fitting, rows.size()));
  core::RandomStream random(seed, 0, "learning.linear");
  for (std::size_t i = 0; i < fitting; ++i) {
    std::swap(rows[i], rows[i + random.index(rows.size() - i)]);
  }
  rows.resize(fitting);
  std::sort(rows.begin(), rows.end());
  return rows;
}

std::size_t values_of_all(const std::vector<learning::ModalityExtent>& extents) {
  std::size_t values = 0;
  for (const learning::ModalityExtent& extent : extents) values += learning::values_in(extent);
  return values;
}

/// Of every rank all samples: each finds planes of its own classes.
LinearSamples read_samples(const Learner::State& learner, learning::SampleSource& source,
                           const learning::LabelledSamples& samples, Trained& trained) {
  const learning::LearningOptions& options = learner.method.learning;
  const std::size_t values = values_of_all(learner.extents);
  const std::vector<std::uint32_t> rows = fitting_rows(
      samples.rows(learning::Part::train), options.memory, values, options.seed, trained.remarks);
  learning::BatchReader reader(source, samples, learner.method, rows, options.memory / 8);
  LinearSamples found(values);
  reader.begin({});
  for (learning::Batch batch; reader.next(read_batch, batch);) {
    const torch::Tensor all = joined(tensors_of(batch, reader.layouts())).contiguous();
    for (std::size_t i = 0; i < batch.rows.size(); ++i) {
      found.add({all.data_ptr<float>() + i * values, values}, batch.labels[i]);
    }
  }
  trained.silent = reader.silent();
  return found;
}

}  // namespace

Trained train_linear_machines(Learner::State& learner, learning::SampleSource& source,
                              const learning::LabelledSamples& samples, const LearningRanks& ranks,
                              const LearningWatch& watch) {
  const double start = core::monotonic_seconds();
  const std::size_t classes = learner.classes.size(), width = values_of_all(learner.extents) + 1;
  Trained trained;
  trained.parameters = static_cast<std::int64_t>(classes * width);
  std::optional<LinearSamples> given;
  std::exception_ptr error;
  try {
    given = read_samples(learner, source, samples, trained);
  } catch (...) {
    error = std::current_exception();
  }
  ranks.agree(error);
  std::vector<float> planes(classes * width, 0.0F);
  const auto size = static_cast<std::size_t>(ranks.size);
  for (std::size_t first = 0; first < classes && !trained.interrupted; first += size) {
    const std::size_t c = first + static_cast<std::size_t>(ranks.rank);
    if (c < classes) {
      const std::vector<double> plane =
          one_against_rest(*given, static_cast<std::int64_t>(c), learner.method.cost,
                           core::stable_hash(fmt::format("svm {}", learner.method.learning.seed)));
      std::transform(plane.begin(), plane.end(),
                     planes.begin() + static_cast<std::ptrdiff_t>(c * width),
                     [](double value) { return static_cast<float>(value); });
    }
    float stop = watch.stop && watch.stop() ? 1 : 0;
    ranks.sum(std::span(&stop, 1));
    trained.interrupted = stop > 0;
  }
  ranks.sum(planes);
  const torch::NoGradGuard no_gradient;
  const torch::Tensor all = torch::tensor(planes).view(
      {static_cast<std::int64_t>(classes), static_cast<std::int64_t>(width)});
  auto weights = learner.classifier->named_parameters();
  weights["classify.weight"].copy_(all.slice(1, 0, -1));
  weights["classify.bias"].copy_(all.slice(1, -1).squeeze(1));
  trained.seconds = core::monotonic_seconds() - start;
  return trained;
}

}  // namespace carillon::eval::networks
