#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/learning/batches.hpp"
#include "eval/networks/detail/networks.hpp"
#include "eval/networks/detail/outliers.hpp"
#include "eval/networks/training.hpp"

namespace carillon::eval::networks {

/// Samples that are answered at a time.
inline constexpr std::size_t answer_batch = 256;

/// Sums of a step or a pass over samples, as ranks add them up.
struct Tally {
  float loss = 0, right = 0, samples = 0, failed = 0, stop = 0;
  static constexpr std::size_t numbers = 5;
  void put(std::span<float> to) const {
    const float values[numbers] = {loss, right, samples, failed, stop};
    std::copy_n(values, numbers, to.begin());
  }
  static Tally of(std::span<const float> from) {
    return {from[0], from[1], from[2], from[3], from[4]};
  }
};

/// A batch's modalities; its memory stays the batch's.
std::vector<torch::Tensor> tensors_of(learning::Batch& batch,
                                      const std::vector<learning::ModalityLayout>& layouts);

/// The same where a network is computed.
std::vector<torch::Tensor> moved_to(const torch::Device& device,
                                    std::vector<torch::Tensor> modalities);

struct Learner::State {
  learning::Method method;
  std::vector<learning::ModalityExtent> extents;
  std::vector<std::string> classes;
  std::shared_ptr<Classifier> classifier;
  torch::Device device = torch::kCPU;
  std::optional<Outliers> outliers;  ///< while it learns, where it is to meet some

  /// Loss and right answers of a batch; with `learn` the gradient too.
  Tally look_at(learning::Batch& batch, const std::vector<learning::ModalityLayout>& layouts,
                bool learn);
};

}  // namespace carillon::eval::networks
