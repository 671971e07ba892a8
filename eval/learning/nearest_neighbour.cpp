#include "eval/learning/nearest_neighbour.hpp"

#include <algorithm>

#include "eval/learning/batches.hpp"
#include "eval/learning/learner_state.hpp"

namespace carillon::eval {

namespace {

/// Training samples that distances are taken to at a time.
constexpr std::size_t known_batch = 1024;

struct Asked {
  std::vector<std::uint32_t> rows;
  torch::Tensor values;
};

/// All values of some rows, n x values.
Asked read_all(BatchReader& reader) {
  Asked asked;
  std::vector<torch::Tensor> parts;
  reader.begin({});
  for (Batch batch; reader.next(answer_batch, batch);) {
    parts.push_back(joined(tensors_of(batch, reader.layouts())).clone());
    asked.rows.insert(asked.rows.end(), batch.rows.begin(), batch.rows.end());
  }
  if (!parts.empty()) asked.values = torch::cat(parts, 0);
  return asked;
}

}  // namespace

std::vector<float> ask_neighbours(const Method& method, SampleSource& source,
                                  const LabelledSamples& samples,
                                  const std::vector<std::uint32_t>& rows,
                                  const LearningRanks& ranks) {
  const std::size_t classes = samples.classes.size();
  std::vector<float> shares(rows.size() * classes, 0.0F);
  std::exception_ptr error;
  try {
    const torch::NoGradGuard no_gradient;
    const double memory = method.learning.memory;
    BatchReader asking(source, samples, method.senses, rows_of_rank(rows, ranks.rank, ranks.size),
                       memory);
    const Asked asked = read_all(asking);
    BatchReader known(source, samples, method.senses, samples.rows(Part::train), memory);
    torch::Tensor nearest, labels;  // asked x k, ascending
    known.begin({});
    for (Batch batch; !asked.rows.empty() && known.next(known_batch, batch);) {
      const torch::Tensor distances =
          torch::cdist(asked.values, joined(tensors_of(batch, known.layouts())));
      const torch::Tensor label =
          torch::tensor(batch.labels).unsqueeze(0).expand({distances.size(0), -1});
      nearest = nearest.defined() ? torch::cat({nearest, distances}, 1) : distances;
      labels = labels.defined() ? torch::cat({labels, label}, 1) : label;
      const std::int64_t keep = std::min(method.neighbours, nearest.size(1));
      const auto [values, at] = nearest.topk(keep, 1, false);
      nearest = values;
      labels = labels.gather(1, at);
    }
    for (std::size_t i = 0; i < asked.rows.size(); ++i) {
      const auto row = static_cast<std::size_t>(
          std::lower_bound(rows.begin(), rows.end(), asked.rows[i]) - rows.begin());
      float* share = shares.data() + row * classes;
      const torch::Tensor own = labels[static_cast<std::int64_t>(i)].contiguous();
      const std::int64_t* label = own.data_ptr<std::int64_t>();
      const std::int64_t count = own.numel();
      const float vote = 1 / static_cast<float>(count);
      for (std::int64_t n = 0; n < count; ++n) share[label[n]] += vote;
      const float most = *std::max_element(share, share + classes);
      const std::int64_t* first =
          std::find_if(label, label + count, [&](std::int64_t c) { return share[c] == most; });
      share[*first] += vote / 2;
    }
  } catch (...) {
    error = std::current_exception();
  }
  ranks.agree(error);
  ranks.sum(shares);
  return shares;
}

}  // namespace carillon::eval
