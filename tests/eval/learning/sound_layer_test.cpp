// SoundNet's layer against torch's own convolution, normalisation, rectifier and maximum.
#include "eval/networks/detail/sound_layer.hpp"

#include <gtest/gtest.h>

namespace carillon::eval {
namespace {

struct LayerCase {
  std::int64_t from, to, kernel, window, time;
};

std::ostream& operator<<(std::ostream& stream, const LayerCase& layer) {
  return stream << layer.from << " to " << layer.to << ", " << layer.kernel << " / " << layer.window
                << ", " << layer.time;
}

/// The same layer by torch: samples x channels x time.
class Reference {
 public:
  Reference(networks::SoundLayer& layer, double momentum = 0.1)
      : layer_(layer),
        momentum_(momentum),
        weight(layer->weight().detach().clone().requires_grad_()),
        scale(layer->norm()->weight.detach().clone().requires_grad_()),
        shift(layer->norm()->bias.detach().clone().requires_grad_()),
        mean(layer->norm()->running_mean.clone()),
        variance(layer->norm()->running_var.clone()) {}

  torch::Tensor forward(const torch::Tensor& input, bool training) {
    torch::Tensor values = torch::conv1d(input, weight, {}, 2, layer_->kernel() / 2);
    values = values.slice(2, 0, values.size(2) / layer_->window() * layer_->window());
    values =
        torch::batch_norm(values, scale, shift, mean, variance, training, momentum_, 1e-5, false);
    return torch::max_pool1d(torch::relu(values), layer_->window());
  }

 private:
  networks::SoundLayer& layer_;
  double momentum_;

 public:
  torch::Tensor weight, scale, shift, mean, variance;
};

double largest_difference(const torch::Tensor& found, const torch::Tensor& expected) {
  return (found - expected).abs().max().item<double>() / expected.abs().max().item<double>();
}

class SoundLayers : public testing::TestWithParam<LayerCase> {};

TEST_P(SoundLayers, AreConvolutionNormalisationRectifierAndMaximum) {
  const auto [from, to, kernel, window, time] = GetParam();
  torch::manual_seed(5);
  networks::SoundLayer layer(from, to, kernel, window);
  {
    const torch::NoGradGuard no_gradient;  // some scales below 0: the least value is the maximum
    layer->norm()->weight.copy_(torch::randn({to}));
    layer->norm()->bias.copy_(torch::randn({to}));
  }
  Reference reference(layer);
  const torch::Tensor input = torch::randn({3, from, time}), by_layer = input.clone(),
                      by_torch = input.clone();
  by_layer.requires_grad_();
  by_torch.requires_grad_();
  layer->train();
  const torch::Tensor found = layer->forward(by_layer.transpose(1, 2)).transpose(1, 2);
  const torch::Tensor expected = reference.forward(by_torch, true);
  ASSERT_EQ(found.sizes(), expected.sizes());
  EXPECT_LT(largest_difference(found, expected), 1e-5);
  EXPECT_LT(largest_difference(layer->norm()->running_mean, reference.mean), 1e-5);
  EXPECT_LT(largest_difference(layer->norm()->running_var, reference.variance), 1e-5);
  const torch::Tensor slope = torch::randn(found.sizes());
  (found * slope).sum().backward();
  (expected * slope).sum().backward();
  EXPECT_LT(largest_difference(by_layer.grad(), by_torch.grad()), 1e-4);
  EXPECT_LT(largest_difference(layer->weight().grad(), reference.weight.grad()), 1e-4);
  EXPECT_LT(largest_difference(layer->norm()->weight.grad(), reference.scale.grad()), 1e-4);
  EXPECT_LT(largest_difference(layer->norm()->bias.grad(), reference.shift.grad()), 1e-4);
  layer->eval();
  EXPECT_LT(largest_difference(layer->forward(input.transpose(1, 2)).transpose(1, 2),
                               reference.forward(input, false)),
            1e-5);
}

TEST_P(SoundLayers, AreTheSameInDoublePrecision) {
  const auto [from, to, kernel, window, time] = GetParam();
  torch::manual_seed(6);
  networks::SoundLayer layer(from, to, kernel, window);
  const torch::Tensor input = torch::randn({3, time, from});
  layer->train();
  const torch::Tensor found = layer->forward(input);
  layer->to(torch::kFloat64);
  EXPECT_LT(largest_difference(found, layer->forward(input.to(torch::kFloat64))), 1e-5);
}

// Both of SoundNet's first layers, one without a maximum, and times that leave outputs over.
INSTANTIATE_TEST_SUITE_P(Some, SoundLayers,
                         testing::Values(LayerCase{1, 32, 64, 8, 1003},
                                         LayerCase{1, 16, 64, 8, 640},
                                         LayerCase{32, 64, 32, 8, 141}, LayerCase{16, 32, 4, 1, 7},
                                         LayerCase{16, 16, 8, 4, 50}));

}  // namespace
}  // namespace carillon::eval
