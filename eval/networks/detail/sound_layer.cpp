#include "eval/networks/detail/sound_layer.hpp"

#include <cmath>
#include <vector>

#include "eval/networks/detail/normalised_maximum.hpp"

namespace carillon::eval::networks {

namespace {

namespace functional = torch::nn::functional;

constexpr std::int64_t stride = 2;

std::span<const float> values_of(const torch::Tensor& tensor) {
  return {tensor.data_ptr<float>(), static_cast<std::size_t>(tensor.numel())};
}

std::span<float> values_to(torch::Tensor& tensor) {
  return {tensor.data_ptr<float>(), static_cast<std::size_t>(tensor.numel())};
}

MaximumExtent extent_of(const torch::Tensor& values, std::int64_t window) {
  return {.rows = static_cast<std::size_t>(values.size(0) * values.size(1)),
          .channels = static_cast<std::size_t>(values.size(2)),
          .window = static_cast<std::size_t>(window)};
}

/// Normalised over the batch, rectified, the maximum of each window; with its gradient.
class NormalisedMaximum : public torch::autograd::Function<NormalisedMaximum> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context,
                               const torch::Tensor& values, const torch::Tensor& weight,
                               const torch::Tensor& bias, const torch::Tensor& running_mean,
                               const torch::Tensor& running_variance, std::int64_t window,
                               double momentum, double epsilon) {
    const MaximumExtent extent = extent_of(values, window);
    torch::Tensor mean = torch::empty_like(weight), variance = torch::empty_like(weight);
    channel_moments(values.data_ptr<float>(), extent, values_to(mean), values_to(variance));
    const auto rows = static_cast<double>(extent.rows);
    running_mean.mul_(1 - momentum).add_(mean, momentum);
    running_variance.mul_(1 - momentum).add_(variance, momentum * rows / (rows - 1));
    const torch::Tensor inverse = (variance + epsilon).rsqrt();
    const torch::Tensor scale = weight * inverse;
    const torch::Tensor shift = bias - mean * scale;
    const std::int64_t outputs = values.size(1) / window;
    torch::Tensor maxima = torch::empty({values.size(0), outputs, values.size(2)});
    torch::Tensor peaks = torch::empty_like(maxima);
    torch::Tensor places = torch::empty(maxima.sizes(), torch::kInt32);
    normalised_maximum(values.data_ptr<float>(), extent, values_of(scale), values_of(shift),
                       maxima.data_ptr<float>(), peaks.data_ptr<float>(),
                       places.data_ptr<std::int32_t>());
    context->save_for_backward({values, mean, inverse, scale, maxima, peaks, places});
    context->saved_data["window"] = window;
    return maxima;
  }

  /// Ioffe and Szegedy 2015, section 3, with the gradient at the maxima alone.
  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 torch::autograd::variable_list gradients) {
    const torch::autograd::variable_list saved = context->get_saved_variables();
    const torch::Tensor &values = saved[0], &mean = saved[1], &inverse = saved[2],
                        &scale = saved[3], &maxima = saved[4], &peaks = saved[5],
                        &places = saved[6];
    const torch::Tensor gradient = gradients[0].contiguous();
    const MaximumExtent extent = extent_of(values, context->saved_data["window"].toInt());
    std::vector<double> plain(extent.channels, 0.0), by_peak(extent.channels, 0.0);
    maximum_sums(gradient.data_ptr<float>(), maxima.data_ptr<float>(), peaks.data_ptr<float>(),
                 extent, plain, by_peak);
    const torch::Tensor sum = torch::tensor(plain), by_value = torch::tensor(by_peak);
    const torch::Tensor by_weight = (by_value - sum * mean) * inverse;
    const auto rows = static_cast<double>(extent.rows);
    const torch::Tensor linear = (-scale * inverse * by_weight / rows).to(torch::kFloat32);
    const torch::Tensor constant = (-scale * sum / rows - linear * mean).to(torch::kFloat32);
    const torch::Tensor found = torch::empty_like(values);
    maximum_gradient(values.data_ptr<float>(), gradient.data_ptr<float>(), maxima.data_ptr<float>(),
                     places.data_ptr<std::int32_t>(), extent, values_of(scale), values_of(constant),
                     values_of(linear), found.data_ptr<float>());
    return {found, by_weight.to(torch::kFloat32), sum.to(torch::kFloat32), {}, {}, {}, {}, {}};
  }
};

/// The same by torch's own operations, with statistics that are there, or on another device.
torch::Tensor maximum_by_steps(const torch::Tensor& values, torch::nn::BatchNorm1d& norm,
                               std::int64_t window, bool over_batch) {
  const torch::Tensor normalised =
      functional::batch_norm(values.flatten(0, 1), norm->running_mean, norm->running_var,
                             functional::BatchNormFuncOptions()
                                 .weight(norm->weight)
                                 .bias(norm->bias)
                                 .training(over_batch)
                                 .momentum(norm->options.momentum())
                                 .eps(norm->options.eps()));
  const torch::Tensor rectified = torch::relu(normalised);
  return rectified.view({values.size(0), values.size(1) / window, window, values.size(2)}).amax(2);
}

}  // namespace

SoundLayerImpl::SoundLayerImpl(std::int64_t from, std::int64_t to, std::int64_t kernel,
                               std::int64_t window)
    : window_(window), phases_(from == 1 ? window : 1) {
  weight_ = register_parameter("weight", torch::empty({to, from, kernel}));
  // As torch's own convolutions begin.
  torch::nn::init::kaiming_uniform_(weight_, std::sqrt(5.0));
  norm_ = register_module("norm", torch::nn::BatchNorm1d(to));
}

torch::Tensor SoundLayerImpl::convolved(const torch::Tensor& input) const {
  const std::int64_t to = weight_.size(0), from = weight_.size(1), kernel = weight_.size(2);
  const std::int64_t padding = kernel / 2, time = input.size(1);
  const std::int64_t outputs = ((time + 2 * padding - kernel) / stride + 1) / window_ * window_;
  // Blocks of input that `phases` outputs begin in, and the blocks that these see.
  const std::int64_t block = stride * phases_;
  const std::int64_t seen = (stride * (phases_ - 1) + kernel + block - 1) / block;
  const std::int64_t blocks = outputs / phases_ + seen - 1;
  const torch::Tensor padded =
      torch::constant_pad_nd(input, {0, 0, padding, blocks * block - padding - time});
  std::vector<torch::Tensor> shifted;
  for (std::int64_t phase = 0; phase < phases_; ++phase) {
    const std::int64_t before = stride * phase;
    shifted.push_back(torch::constant_pad_nd(weight_, {before, seen * block - kernel - before}));
  }
  const torch::Tensor weights = torch::stack(shifted)
                                    .view({phases_ * to, from, seen, block})
                                    .permute({0, 3, 1, 2})
                                    .reshape({phases_ * to, block * from, 1, seen});
  const torch::Tensor image =
      padded.reshape({input.size(0), 1, blocks, block * from}).permute({0, 3, 1, 2});
  const torch::Tensor convolved =
      torch::conv2d(image, weights.contiguous(torch::MemoryFormat::ChannelsLast));
  return convolved.permute({0, 2, 3, 1}).reshape({input.size(0), outputs, to});
}

torch::Tensor SoundLayerImpl::forward(const torch::Tensor& input) {
  const torch::Tensor values = convolved(input);
  // A single value has no variance: the last sample of an epoch, of a short clip.
  const bool over_batch = is_training() && values.size(0) * values.size(1) > 1;
  const bool by_kernels =
      over_batch && values.device().is_cpu() && values.dtype() == torch::kFloat32;
  if (!by_kernels) return maximum_by_steps(values, norm_, window_, over_batch);
  if (norm_->num_batches_tracked.defined()) norm_->num_batches_tracked += 1;
  return NormalisedMaximum::apply(values.contiguous(), norm_->weight, norm_->bias,
                                  norm_->running_mean, norm_->running_var, window_,
                                  norm_->options.momentum().value_or(0.1), norm_->options.eps());
}

}  // namespace carillon::eval::networks
