#pragma once

// The only header that brings in libtorch: a file that includes it takes a quarter of a minute and
// 1 GB to compile.
#include <torch/torch.h>

#include <memory>
#include <vector>

#include "eval/learning/method.hpp"

namespace carillon::eval::networks {

/// What is trained: modalities, each n x its extent, to logits, n x classes.
class Classifier : public torch::nn::Module {
 public:
  virtual torch::Tensor forward(const std::vector<torch::Tensor>& modalities) = 0;
  /// What the last layer classifies, n x features.
  virtual torch::Tensor features(const std::vector<torch::Tensor>& modalities) = 0;
};

/// A network's branches with their fusion and the layer that classifies, or for a linear support
/// vector machine that layer alone, on all values of all modalities. First weights are drawn from
/// torch's generator.
/// @param extents  of the method's modalities, in their order
/// @throws InputError  a modality's extent is too small for a branch
std::shared_ptr<Classifier> make_classifier(const learning::Method& method,
                                            const std::vector<learning::ModalityExtent>& extents,
                                            std::int64_t classes);

/// All values of all modalities, n x values.
torch::Tensor joined(const std::vector<torch::Tensor>& modalities);

}  // namespace carillon::eval::networks
