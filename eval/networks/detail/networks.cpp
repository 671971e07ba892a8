#include "eval/networks/detail/networks.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "eval/networks/detail/copies.hpp"
#include "eval/networks/detail/sound_layer.hpp"

namespace carillon::eval::networks {

namespace nn = torch::nn;

namespace {

/// Features of a chain of layers for one sample of zeros, which tells how many there are.
std::int64_t features_after(nn::Sequential& layers, const learning::ModalityExtent& extent) {
  std::vector<std::int64_t> one = {1};
  one.insert(one.end(), extent.begin(), extent.end());
  const torch::NoGradGuard no_gradient;
  layers->eval();
  const std::int64_t features = layers->forward(torch::zeros(one)).size(1);
  layers->train();
  return features;
}

/// A chain of layers, flattened, and a dense layer of `width` features behind it.
nn::Sequential with_dense_layer(nn::Sequential layers, const learning::ModalityExtent& extent,
                                std::int64_t width, double dropout_before, double dropout_after) {
  layers->push_back(nn::Flatten());
  const std::int64_t features = features_after(layers, extent);
  if (dropout_before > 0) layers->push_back(nn::Dropout(dropout_before));
  layers->push_back(nn::Linear(features, width));
  layers->push_back(nn::ReLU());
  if (dropout_after > 0) layers->push_back(nn::Dropout(dropout_after));
  return layers;
}

[[noreturn]] void too_small(const std::string& branch, const std::string& needs,
                            const learning::ModalityExtent& extent) {
  std::string text;
  for (const std::int64_t side : extent)
    text += fmt::format("{}{}", text.empty() ? "" : " x ", side);
  throw core::InputError(fmt::format("{} needs {}, and gets {}", branch, needs, text),
                         branch.ends_with("isnn") ? "smaller `kernel` or `pooling`" : "");
}

nn::Sequential isnn(const learning::LayerSizes& sizes, const learning::ModalityExtent& extent) {
  nn::Sequential layers;
  std::int64_t channels = 1, bands = extent[1], frames = extent[2];
  for (std::size_t i = 0; i < sizes.layers.size(); ++i) {
    const learning::SpectrogramLayer& layer = sizes.layers[i];
    const std::int64_t min_bands = layer.kernel_bands + layer.pool_bands - 1;
    const std::int64_t min_frames = layer.kernel_frames + layer.pool_frames - 1;
    if (bands < min_bands || frames < min_frames) {
      too_small(sizes.layers.size() == 1 ? "isnn" : fmt::format("convolution {} of isnn", i + 1),
                fmt::format("at least {} bands and {} frames", min_bands, min_frames),
                {bands, frames});
    }
    layers->push_back(nn::Conv2d(
        nn::Conv2dOptions(channels, layer.filters, {layer.kernel_bands, layer.kernel_frames})));
    // In this order: the same values, and fewer of them to go through.
    layers->push_back(nn::MaxPool2d(nn::MaxPool2dOptions({layer.pool_bands, layer.pool_frames})));
    layers->push_back(nn::ReLU());
    channels = layer.filters;
    bands = (bands - layer.kernel_bands + 1) / layer.pool_bands;
    frames = (frames - layer.kernel_frames + 1) / layer.pool_frames;
  }
  return with_dense_layer(layers, extent, sizes.width, sizes.dropout, sizes.dropout);
}

/// Maturana and Scherer 2015, with the drop-out of the authors' program. Of turned copies it learns
/// from one that is drawn, and answers with the mean of their features: of their logits where one
/// linear layer follows.
nn::Sequential voxnet(const learning::LayerSizes& sizes, const learning::ModalityExtent& extent) {
  if (*std::min_element(extent.begin() + 1, extent.end()) < 11) {
    too_small("voxnet", "at least 11 voxels on each side", extent);
  }
  const auto leaky = nn::LeakyReLUOptions().negative_slope(0.1);
  const std::int64_t turns = extent[0];
  nn::Sequential layers;
  if (turns > 1)
    layers->push_back(Copies(learning::ModalityExtent{1, extent[1], extent[2], extent[3]}, true));
  layers->push_back(nn::Conv3d(nn::Conv3dOptions(1, 32, 5).stride(2)));
  layers->push_back(nn::LeakyReLU(leaky));
  layers->push_back(nn::Dropout(0.2));
  layers->push_back(nn::Conv3d(nn::Conv3dOptions(32, 32, 3)));
  layers->push_back(nn::LeakyReLU(leaky));
  layers->push_back(nn::MaxPool3d(nn::MaxPool3dOptions(2)));
  layers = with_dense_layer(layers, extent, sizes.width, 0.3, 0.4);
  if (turns > 1) layers->push_back(OverCopies(turns, OverCopiesImpl::By::mean));
  return layers;
}

/// Means over what is left of time, so that clips of any length fit.
nn::Sequential soundnet(const learning::LayerSizes& sizes, const learning::ModalityExtent& extent,
                        bool deep) {
  // Less leaves the window of a maximum without its four or eight values.
  const std::int64_t shortest = deep ? 4574 : 3550;
  if (extent[1] < shortest) {
    too_small(deep ? "soundnet8" : "soundnet5",
              fmt::format("clips of at least {} samples at 22,050 Hz", shortest), extent);
  }
  nn::Sequential layers;
  layers->push_back(TimeFirst());
  if (deep) {
    layers->push_back(SoundLayer(1, 16, 64, 8));
    layers->push_back(SoundLayer(16, 32, 32, 8));
    layers->push_back(SoundLayer(32, 64, 16, 1));
    layers->push_back(SoundLayer(64, 128, 8, 1));
    layers->push_back(SoundLayer(128, 256, 4, 4));
    layers->push_back(SoundLayer(256, 512, 4, 1));
    layers->push_back(SoundLayer(512, 1024, 4, 1));
  } else {
    layers->push_back(SoundLayer(1, 32, 64, 8));
    layers->push_back(SoundLayer(32, 64, 32, 8));
    layers->push_back(SoundLayer(64, 128, 16, 8));
    layers->push_back(SoundLayer(128, 256, 8, 1));
  }
  layers->push_back(TimeMean());
  return with_dense_layer(layers, extent, sizes.width, 0, sizes.dropout);
}

/// Several views go through the same convolutions, and the largest of each feature over the views
/// goes on: the order of views does not matter (Su et al. 2015).
nn::Sequential image(const learning::LayerSizes& sizes, const learning::ModalityExtent& extent) {
  nn::Sequential layers;
  const bool several = extent.size() == 4;
  std::int64_t channels = several ? extent[1] : extent[0];
  if (several) {
    layers->push_back(Copies(learning::ModalityExtent(extent.begin() + 1, extent.end()), false));
  }
  for (const std::int64_t filters : {16, 32, 64}) {
    layers->push_back(nn::Conv2d(nn::Conv2dOptions(channels, filters, 3).padding(1)));
    layers->push_back(nn::ReLU());
    layers->push_back(nn::MaxPool2d(nn::MaxPool2dOptions(2)));
    channels = filters;
  }
  if (several) {
    layers->push_back(OverCopies(extent[0], OverCopiesImpl::By::maximum));
  }
  return with_dense_layer(layers, extent, sizes.width, sizes.dropout, sizes.dropout);
}

nn::Sequential touch(const learning::LayerSizes& sizes, const learning::ModalityExtent& extent) {
  if (extent[1] < 64) too_small("touch", "at least 64 ticks", extent);
  nn::Sequential layers;
  std::int64_t channels = extent[0];
  for (const std::int64_t filters : {16, 32, 64}) {
    layers->push_back(nn::Conv1d(nn::Conv1dOptions(channels, filters, 16).stride(2).padding(8)));
    layers->push_back(nn::ReLU());
    layers->push_back(nn::MaxPool1d(nn::MaxPool1dOptions(2)));
    channels = filters;
  }
  layers->push_back(nn::AdaptiveMaxPool1d(nn::AdaptiveMaxPool1dOptions(8)));
  return with_dense_layer(layers, extent, sizes.width, sizes.dropout, sizes.dropout);
}

nn::Sequential make_branch(learning::Branch branch, const learning::LayerSizes& sizes,
                           const learning::ModalityExtent& extent) {
  switch (branch) {
    case learning::Branch::isnn:
      return isnn(sizes, extent);
    case learning::Branch::soundnet5:
      return soundnet(sizes, extent, false);
    case learning::Branch::soundnet8:
      return soundnet(sizes, extent, true);
    case learning::Branch::voxnet:
      return voxnet(sizes, extent);
    case learning::Branch::image:
      return image(sizes, extent);
    case learning::Branch::touch:
      return touch(sizes, extent);
  }
  return {};
}

/// Projections of each branch and their element-wise product. Multiplicative fusion stops there,
/// with projections that tanh keeps within 1 (Kim et al. 2017); bilinear pooling goes on with
/// drop-out, sums over `factors` neighbours, signed square root and unit length (Yu et al. 2017,
/// eq. 5 and section 3.2).
class ProductImpl : public nn::Module {
 public:
  ProductImpl(std::size_t branches, std::int64_t width, std::int64_t outputs, std::int64_t factors,
              bool pool)
      : outputs_(outputs), factors_(factors), pool_(pool) {
    for (std::size_t i = 0; i < branches; ++i) {
      projections_.push_back(register_module(
          fmt::format("projection{}", i), nn::Linear(width, pool ? outputs * factors : outputs)));
    }
    drop_ = register_module("drop", nn::Dropout(0.1));
  }

  torch::Tensor forward(const std::vector<torch::Tensor>& features) {
    torch::Tensor product = projections_[0](features[0]);
    if (!pool_) product = torch::tanh(product);
    for (std::size_t i = 1; i < features.size(); ++i) {
      const torch::Tensor other = projections_[i](features[i]);
      product = product * (pool_ ? other : torch::tanh(other));
    }
    if (!pool_) return product;
    const torch::Tensor pooled = drop_(product).view({-1, outputs_, factors_}).sum(2);
    // The root's slope at 0 is kept finite.
    constexpr double minimum = 1e-12;
    const torch::Tensor root = torch::sign(pooled) * torch::sqrt(torch::abs(pooled) + minimum);
    return nn::functional::normalize(root, nn::functional::NormalizeFuncOptions().p(2).dim(1));
  }

 private:
  std::vector<nn::Linear> projections_;
  nn::Dropout drop_{nullptr};
  std::int64_t outputs_, factors_;
  bool pool_;
};
TORCH_MODULE(Product);

class Network final : public Classifier {
 public:
  Network(const learning::Method& method, const std::vector<learning::ModalityExtent>& extents,
          std::int64_t classes)
      : fusion_(method.fusion) {
    const learning::LayerSizes& sizes = method.sizes;
    for (std::size_t i = 0; i < method.branches.size(); ++i) {
      branches_.push_back(register_module(fmt::format("branch{}", i),
                                          make_branch(method.branches[i], sizes, extents[i])));
    }
    const std::size_t count = branches_.size();
    std::int64_t features = sizes.width;
    if (count > 1 && fusion_ == learning::Fusion::concatenate) {
      features *= static_cast<std::int64_t>(count);
    } else if (count > 1 && fusion_ != learning::Fusion::add) {
      const bool pool = fusion_ == learning::Fusion::bilinear;
      if (pool) features = sizes.fused;
      product_ =
          register_module("product", Product(count, sizes.width, features, sizes.factors, pool));
    }
    classify_ = register_module("classify", nn::Linear(features, classes));
  }

  torch::Tensor features(const std::vector<torch::Tensor>& modalities) override {
    std::vector<torch::Tensor> features;
    for (std::size_t i = 0; i < branches_.size(); ++i) {
      features.push_back(branches_[i]->forward(modalities[i]));
    }
    if (features.size() == 1) return features[0];
    if (product_) return product_->forward(features);
    if (fusion_ == learning::Fusion::concatenate) return torch::cat(features, 1);
    return torch::stack(features).sum(0);
  }

  torch::Tensor forward(const std::vector<torch::Tensor>& modalities) override {
    return classify_(features(modalities));
  }

 private:
  learning::Fusion fusion_;
  std::vector<nn::Sequential> branches_;
  Product product_{nullptr};
  nn::Linear classify_{nullptr};
};

class LinearClassifier final : public Classifier {
 public:
  LinearClassifier(const std::vector<learning::ModalityExtent>& extents, std::int64_t classes) {
    std::size_t values = 0;
    for (const learning::ModalityExtent& extent : extents) values += learning::values_in(extent);
    classify_ = register_module("classify", nn::Linear(static_cast<std::int64_t>(values), classes));
  }
  torch::Tensor features(const std::vector<torch::Tensor>& modalities) override {
    return joined(modalities);
  }
  torch::Tensor forward(const std::vector<torch::Tensor>& modalities) override {
    return classify_(joined(modalities));
  }

 private:
  nn::Linear classify_{nullptr};
};

}  // namespace

std::shared_ptr<Classifier> make_classifier(const learning::Method& method,
                                            const std::vector<learning::ModalityExtent>& extents,
                                            std::int64_t classes) {
  if (method.kind == learning::MethodKind::linear_svm) {
    return std::make_shared<LinearClassifier>(extents, classes);
  }
  return std::make_shared<Network>(method, extents, classes);
}

torch::Tensor joined(const std::vector<torch::Tensor>& modalities) {
  std::vector<torch::Tensor> flat;
  for (const torch::Tensor& modality : modalities) flat.push_back(modality.flatten(1));
  return torch::cat(flat, 1);
}

}  // namespace carillon::eval::networks
