#include "eval/networks/detail/layer_table.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "eval/networks/detail/copies.hpp"
#include "eval/networks/detail/sound_layer.hpp"

namespace carillon::eval::networks {

namespace nn = torch::nn;
using nlohmann::ordered_json;

namespace {

using Layers = std::vector<ordered_json>;

ordered_json weights_named(const char* kind, const std::string& name) {
  return {{"kind", kind}, {"weight", name + ".weight"}, {"bias", name + ".bias"}};
}

template <std::size_t axes, class Convolution>
ordered_json convolution(const Convolution& layer, const std::string& name) {
  ordered_json row = weights_named("convolution", name);
  row["stride"] = *layer.options.stride();
  row["padding"] = *c10::get<torch::ExpandingArray<axes>>(layer.options.padding());
  return row;
}

template <class Maximum>
ordered_json maximum(const Maximum& layer) {
  return {{"kind", "maximum"}, {"window", *layer.options.kernel_size()}};
}

ordered_json rectifier(double slope) {
  return {{"kind", "rectifier"}, {"slope", slope}};
}

Layers sound_layers(const SoundLayerImpl& layer, const std::string& name) {
  ordered_json normalisation = weights_named("normalisation", name + ".norm");
  normalisation["mean"] = name + ".norm.running_mean";
  normalisation["variance"] = name + ".norm.running_var";
  normalisation["epsilon"] = layer.norm()->options.eps();
  Layers rows = {{{"kind", "convolution"},
                  {"weight", name + ".weight"},
                  {"bias", nullptr},
                  {"stride", {2}},
                  {"padding", {layer.kernel() / 2}}},
                 normalisation,
                 rectifier(0)};
  if (layer.window() > 1) rows.push_back({{"kind", "maximum"}, {"window", {layer.window()}}});
  return rows;
}

/// Rows of one module; none of what changes nothing in an answer.
Layers rows_of(const nn::Module& module, const std::string& name) {
  if (module.as<nn::Dropout>() != nullptr || module.as<TimeFirst>() != nullptr) return {};
  if (const auto* layer = module.as<nn::Conv1d>()) return {convolution<1>(*layer, name)};
  if (const auto* layer = module.as<nn::Conv2d>()) return {convolution<2>(*layer, name)};
  if (const auto* layer = module.as<nn::Conv3d>()) return {convolution<3>(*layer, name)};
  if (const auto* layer = module.as<nn::MaxPool1d>()) return {maximum(*layer)};
  if (const auto* layer = module.as<nn::MaxPool2d>()) return {maximum(*layer)};
  if (const auto* layer = module.as<nn::MaxPool3d>()) return {maximum(*layer)};
  if (module.as<nn::ReLU>() != nullptr) return {rectifier(0)};
  if (const auto* layer = module.as<nn::LeakyReLU>()) {
    return {rectifier(layer->options.negative_slope())};
  }
  if (module.as<nn::Linear>() != nullptr) return {weights_named("dense", name)};
  if (module.as<nn::Flatten>() != nullptr) return {{{"kind", "flatten"}}};
  if (const auto* layer = module.as<nn::AdaptiveMaxPool1d>()) {
    return {{{"kind", "adaptive_maximum"}, {"outputs", (*layer->options.output_size())[0]}}};
  }
  if (const auto* layer = module.as<SoundLayer>()) return sound_layers(*layer, name);
  if (const auto* layer = module.as<Copies>()) {
    return {{{"kind", "copies"}, {"shape", layer->shape()}}};
  }
  if (const auto* layer = module.as<OverCopies>()) {
    const char* by = layer->by() == OverCopiesImpl::By::mean ? "mean" : "maximum";
    return {{{"kind", "over_copies"}, {"count", layer->count()}, {"by", by}}};
  }
  if (module.as<TimeMean>() != nullptr) return {{{"kind", "mean"}}};
  throw core::Error(fmt::format("the layer {} ({}) has no description", name, module.name()));
}

ordered_json branch_rows(const nn::Module& branch, const std::string& name) {
  ordered_json rows = ordered_json::array();
  for (const auto& child : branch.named_children()) {
    for (ordered_json& row : rows_of(*child.value(), fmt::format("{}.{}", name, child.key()))) {
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

ordered_json fusion_of(const Classifier& classifier, const learning::Method& method) {
  const auto children = classifier.named_children();
  const bool alone = method.branches.size() < 2;
  ordered_json fusion = {
      {"kind", learning::name_of(alone ? learning::Fusion::concatenate : method.fusion)}};
  const auto* product = children.find("product");
  if (product == nullptr) return fusion;
  fusion["projections"] = ordered_json::array();
  for (std::size_t i = 0; i < method.branches.size(); ++i) {
    fusion["projections"].push_back(weights_named("dense", fmt::format("product.projection{}", i)));
  }
  if (method.fusion == learning::Fusion::bilinear) fusion["factors"] = method.sizes.factors;
  return fusion;
}

}  // namespace

ordered_json layer_table(const Classifier& classifier, const learning::Method& method,
                         const std::vector<learning::ModalityExtent>& extents,
                         const std::vector<std::string>& classes) {
  ordered_json table = {{"format", 1}, {"method", learning::to_json(method)}, {"classes", classes}};
  const auto children = classifier.named_children();
  for (std::size_t i = 0; i < extents.size(); ++i) {
    table["inputs"].push_back(
        {{"modality", learning::name_of(method.modalities[i])}, {"extent", extents[i]}});
    const std::string name = fmt::format("branch{}", i);
    const auto* branch = children.find(name);
    table["branches"].push_back(branch == nullptr ? ordered_json{{{"kind", "flatten"}}}
                                                  : branch_rows(**branch, name));
  }
  table["fusion"] = fusion_of(classifier, method);
  table["classify"] = weights_named("dense", "classify");
  return table;
}

std::map<std::string, torch::Tensor> weights_of(const Classifier& classifier) {
  std::map<std::string, torch::Tensor> weights;
  const auto add = [&](const auto& named) {
    for (const auto& item : named) {
      if (!item.value().is_floating_point()) continue;  // counts of batches
      weights[item.key()] = item.value().detach().to(torch::kCPU).contiguous();
    }
  };
  add(classifier.named_parameters());
  add(classifier.named_buffers());
  return weights;
}

}  // namespace carillon::eval::networks
