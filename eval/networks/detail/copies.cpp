#include "eval/networks/detail/copies.hpp"

#include <utility>

namespace carillon::eval::networks {

CopiesImpl::CopiesImpl(std::vector<std::int64_t> shape, bool draws)
    : shape_(std::move(shape)), draws_(draws) {}

torch::Tensor CopiesImpl::forward(const torch::Tensor& input) {
  std::vector<std::int64_t> each = {-1};
  each.insert(each.end(), shape_.begin(), shape_.end());
  if (!draws_ || !is_training()) return input.reshape(each);
  const std::int64_t samples = input.size(0);
  const auto where = torch::TensorOptions().dtype(torch::kInt64).device(input.device());
  const torch::Tensor drawn = torch::randint(input.size(1), {samples}, where);
  return input.index({torch::arange(samples, where), drawn}).reshape(each);
}

OverCopiesImpl::OverCopiesImpl(std::int64_t count, By by) : count_(count), by_(by) {}

torch::Tensor OverCopiesImpl::forward(const torch::Tensor& input) {
  if (by_ == By::mean && is_training()) return input;
  const torch::Tensor copies = input.unflatten(0, {-1, count_});
  return by_ == By::mean ? copies.mean(1) : copies.amax(1);
}

}  // namespace carillon::eval::networks
