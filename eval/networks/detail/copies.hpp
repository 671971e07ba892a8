#pragma once

#include <torch/torch.h>

#include <cstdint>
#include <vector>

namespace carillon::eval::networks {

/// Copies of each sample, samples x copies x ..., as samples of their own: what follows treats all
/// of them alike, until OverCopies.
class CopiesImpl : public torch::nn::Module {
 public:
  /// @param shape  of one copy: channels, then the modality's own axes
  /// @param draws  while it learns, one copy of each sample that is drawn goes on alone
  CopiesImpl(std::vector<std::int64_t> shape, bool draws);

  torch::Tensor forward(const torch::Tensor& input);
  const std::vector<std::int64_t>& shape() const { return shape_; }

 private:
  std::vector<std::int64_t> shape_;
  bool draws_;
};
TORCH_MODULE(Copies);

/// One of the copies of each sample again: their mean (Maturana and Scherer 2015, whose copies are
/// drawn while it learns: then there is but one), or the largest of each value (Su et al. 2015).
class OverCopiesImpl : public torch::nn::Module {
 public:
  enum class By { mean, maximum };
  OverCopiesImpl(std::int64_t count, By by);

  torch::Tensor forward(const torch::Tensor& input);
  std::int64_t count() const { return count_; }
  By by() const { return by_; }

 private:
  std::int64_t count_;
  By by_;
};
TORCH_MODULE(OverCopies);

}  // namespace carillon::eval::networks
