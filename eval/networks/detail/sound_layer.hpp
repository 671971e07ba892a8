#pragma once

#include <torch/torch.h>

namespace carillon::eval::networks {

/// One layer of SoundNet (Aytar et al. 2016): a convolution of stride 2 with half a kernel of zeros
/// before and after, normalised over batch and time, rectified, and of each `window` outputs the
/// maximum. What fills no window is left out. The shift of what is normalised is the convolution's
/// bias.
///
/// Values lie as samples x time x channels. Where one channel comes in, outputs of a whole window
/// are computed as channels of one convolution over blocks of samples: oneDNN's kernels are several
/// times slower on a single channel.
class SoundLayerImpl : public torch::nn::Module {
 public:
  /// @param from, to  channels; `to` is a multiple of 16
  /// @param kernel    even
  SoundLayerImpl(std::int64_t from, std::int64_t to, std::int64_t kernel, std::int64_t window);

  /// @param input  samples x time x from
  /// @return       samples x outputs_of(time) x to
  torch::Tensor forward(const torch::Tensor& input);

  std::int64_t kernel() const { return weight_.size(2); }
  std::int64_t window() const { return window_; }
  const torch::Tensor& weight() const { return weight_; }
  const torch::nn::BatchNorm1d& norm() const { return norm_; }

 private:
  /// Outputs before the maximum, samples x time x to: whole windows.
  torch::Tensor convolved(const torch::Tensor& input) const;

  torch::Tensor weight_;  ///< to x from x kernel
  torch::nn::BatchNorm1d norm_{nullptr};
  std::int64_t window_;
  std::int64_t phases_;  ///< outputs that are channels of one convolution
};
TORCH_MODULE(SoundLayer);

/// What SoundNet's layers take, samples x time x channels, from samples x channels x time.
class TimeFirstImpl : public torch::nn::Module {
 public:
  torch::Tensor forward(const torch::Tensor& input) { return input.transpose(1, 2); }
};
TORCH_MODULE(TimeFirst);

/// Means over time of what SoundNet's layers give, samples x channels.
class TimeMeanImpl : public torch::nn::Module {
 public:
  torch::Tensor forward(const torch::Tensor& input) { return input.mean(1); }
};
TORCH_MODULE(TimeMean);

}  // namespace carillon::eval::networks
