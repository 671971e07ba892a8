#include "eval/networks/nearest_neighbour.hpp"

#include <algorithm>

#include "eval/learning/batches.hpp"
#include "eval/networks/detail/learner_state.hpp"

namespace carillon::eval::networks {

namespace {

/// Training samples that distances are taken to at a time.
constexpr std::size_t known_batch = 1024;

struct Asked {
  std::vector<std::uint32_t> rows;
  torch::Tensor values;
};

/// All values of some rows, n x values.
Asked read_all(learning::BatchReader& reader) {
  Asked asked;
  std::vector<torch::Tensor> parts;
  reader.begin({});
  for (learning::Batch batch; reader.next(answer_batch, batch);) {
    parts.push_back(joined(tensors_of(batch, reader.layouts())).clone());
    asked.rows.insert(asked.rows.end(), batch.rows.begin(), batch.rows.end());
  }
  if (!parts.empty()) asked.values = torch::cat(parts, 0);
  return asked;
}

/// Rows whose values take half of the memory while they are gathered.
std::size_t rows_within(double memory, const std::vector<learning::ModalityLayout>& layouts) {
  double bytes = 0;
  for (const learning::ModalityLayout& layout : layouts) {
    bytes += static_cast<double>(learning::values_in(layout.extent) * sizeof(float));
  }
  constexpr double gathered = 4;  // in parts and as one, of half
  return std::max<std::size_t>(1, static_cast<std::size_t>(memory / (gathered * bytes)));
}

/// Labels of the nearest known samples of each one asked, the nearest first: asked x neighbours.
torch::Tensor nearest_labels(const torch::Tensor& asked, learning::BatchReader& known,
                             std::int64_t neighbours) {
  torch::Tensor nearest, labels;
  known.begin({});
  for (learning::Batch batch; known.next(known_batch, batch);) {
    const torch::Tensor distances = torch::cdist(asked, joined(tensors_of(batch, known.layouts())));
    const torch::Tensor label =
        torch::tensor(batch.labels).unsqueeze(0).expand({distances.size(0), -1});
    nearest = nearest.defined() ? torch::cat({nearest, distances}, 1) : distances;
    labels = labels.defined() ? torch::cat({labels, label}, 1) : label;
    const auto [values, at] = nearest.topk(std::min(neighbours, nearest.size(1)), 1, false);
    nearest = values;
    labels = labels.gather(1, at);
  }
  return labels.contiguous();
}

/// Each neighbour's vote as a fraction; of equally many the nearest one's class wins.
void vote(const std::int64_t* label, std::int64_t count, std::span<float> fraction) {
  const float one = 1 / static_cast<float>(count);
  for (std::int64_t n = 0; n < count; ++n) fraction[static_cast<std::size_t>(label[n])] += one;
  const float maximum = *std::max_element(fraction.begin(), fraction.end());
  const std::int64_t* first = std::find_if(label, label + count, [&](std::int64_t c) {
    return fraction[static_cast<std::size_t>(c)] == maximum;
  });
  fraction[static_cast<std::size_t>(*first)] += one / 2;
}

}  // namespace

std::vector<float> ask_neighbours(const learning::Method& method, learning::SampleSource& source,
                                  const learning::LabelledSamples& samples,
                                  const std::vector<std::uint32_t>& rows,
                                  const LearningRanks& ranks) {
  const std::size_t classes = samples.classes.size();
  std::vector<float> fractions(rows.size() * classes, 0.0F);
  std::exception_ptr error;
  try {
    const torch::NoGradGuard no_gradient;
    const double memory = method.learning.memory / 2;
    learning::BatchReader known(source, samples, method, samples.rows(learning::Part::train),
                                memory);
    const std::vector<std::uint32_t> own = learning::rows_of_rank(rows, ranks.rank, ranks.size);
    const std::size_t block = rows_within(memory, known.layouts());
    for (std::size_t first = 0; first < own.size(); first += block) {
      const auto begin = own.begin() + static_cast<std::ptrdiff_t>(first);
      const auto count = static_cast<std::ptrdiff_t>(std::min(block, own.size() - first));
      learning::BatchReader asking(source, samples, method, {begin, begin + count}, memory);
      const Asked asked = read_all(asking);
      const torch::Tensor labels = nearest_labels(asked.values, known, method.neighbours);
      for (std::size_t i = 0; i < asked.rows.size(); ++i) {
        const auto row = static_cast<std::size_t>(
            std::lower_bound(rows.begin(), rows.end(), asked.rows[i]) - rows.begin());
        vote(labels.data_ptr<std::int64_t>() + static_cast<std::int64_t>(i) * labels.size(1),
             labels.size(1), std::span(fractions).subspan(row * classes, classes));
      }
    }
  } catch (...) {
    error = std::current_exception();
  }
  ranks.agree(error);
  ranks.sum(fractions);
  return fractions;
}

}  // namespace carillon::eval::networks
