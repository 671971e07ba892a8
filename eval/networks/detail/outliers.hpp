#pragma once

#include <torch/torch.h>

#include <vector>

#include "eval/learning/clip.hpp"
#include "eval/learning/method.hpp"

namespace carillon::eval::networks {

/// Sounds of none of the classes, which a network that hears learns to be unsure of (outlier
/// exposure, Hendrycks, Mazeika and Dietterich 2019, eq. 1): noises of drawn colours, even or
/// swelling and fading, and mains hum, each from its loudest onset on; and the lower part of one
/// class's sound with the upper part of another's, alike to sounds of objects that it does not
/// know.
class Outliers {
 public:
  /// @param format  of the sounds; the noises are drawn once, the same for all ranks
  Outliers(const learning::Method& method, const learning::ClipFormat& format);

  /// Noises, an eighth of the batch (at least one), and at most as many mixes of its sounds, of
  /// each of which they have a fifth to four fifths: pairs that cannot be mixed so, as one lies
  /// below or ends before the other, are left out, since a mix of them would be nearly one of them.
  /// Draws from torch's generator.
  /// @param modalities  the batch's
  std::vector<torch::Tensor> draw(const std::vector<torch::Tensor>& modalities,
                                  const torch::Tensor& labels) const;

  /// Mean over outliers of the cross-entropy of equal fractions of all classes.
  static torch::Tensor loss(const torch::Tensor& logits);

 private:
  std::vector<torch::Tensor> noises_;  ///< of each modality, noises x extent
};

}  // namespace carillon::eval::networks
