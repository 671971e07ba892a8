#include "eval/learning/method.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"

namespace carillon::eval::learning {

std::string_view name_of(Branch branch) {
  switch (branch) {
    case Branch::isnn:
      return "isnn";
    case Branch::soundnet5:
      return "soundnet5";
    case Branch::soundnet8:
      return "soundnet8";
    case Branch::voxnet:
      return "voxnet";
    case Branch::image:
      return "image";
    case Branch::touch:
      return "touch";
  }
  return "";
}

std::string_view name_of(Fusion fusion) {
  switch (fusion) {
    case Fusion::concatenate:
      return "concatenate";
    case Fusion::add:
      return "add";
    case Fusion::multiply:
      return "multiply";
    case Fusion::bilinear:
      return "bilinear";
  }
  return "";
}

std::string_view name_of(MethodKind kind) {
  switch (kind) {
    case MethodKind::network:
      return "network";
    case MethodKind::nearest_neighbour:
      return "nearest_neighbour";
    case MethodKind::linear_svm:
      return "linear_svm";
  }
  return "";
}

std::string_view name_of(Device device) {
  switch (device) {
    case Device::automatic:
      return "auto";
    case Device::cpu:
      return "cpu";
    case Device::cuda:
      return "cuda";
  }
  return "";
}

std::string_view name_of(Schedule schedule) {
  return schedule == Schedule::plateau ? "plateau" : "cosine";
}

Device device_named(const std::string& name) {
  for (const Device device : all_devices) {
    if (name_of(device) == name) return device;
  }
  throw core::InputError(fmt::format("no device \"{}\"", name), "auto, cpu or cuda");
}

Modality modality_of(Branch branch) {
  switch (branch) {
    case Branch::isnn:
      return Modality::spectrogram;
    case Branch::soundnet5:
    case Branch::soundnet8:
      return Modality::waveform;
    case Branch::voxnet:
      return Modality::voxels;
    case Branch::image:
      return Modality::image;
    case Branch::touch:
      return Modality::touch;
  }
  return Modality::spectrogram;
}

namespace {

/// The value of a list whose name a text is.
template <class T, std::size_t n>
T named(const T (&all)[n], const std::string& text) {
  for (const T value : all) {
    if (name_of(value) == text) return value;
  }
  throw core::InputError(fmt::format("\"{}\" is known to another version of the program", text));
}

}  // namespace

bool only_hears(const Method& method) {
  return method.kind == MethodKind::network &&
         std::all_of(method.modalities.begin(), method.modalities.end(), [](Modality modality) {
           return modality == Modality::spectrogram || modality == Modality::waveform;
         });
}

nlohmann::ordered_json to_json(const Method& method) {
  nlohmann::ordered_json json = {{"name", method.name}, {"kind", name_of(method.kind)}};
  json["branches"] = nlohmann::json::array();
  for (const Branch branch : method.branches) json["branches"].push_back(name_of(branch));
  json["modalities"] = nlohmann::json::array();
  for (const Modality modality : method.modalities) json["modalities"].push_back(name_of(modality));
  json["fusion"] = name_of(method.fusion);
  json["neighbours"] = method.neighbours;
  json["cost"] = method.cost;
  json["spectrogram"] = {{"scale", name_of(method.spectrogram.scale)},
                         {"range_db", method.spectrogram.range}};
  const LayerSizes& sizes = method.sizes;
  nlohmann::ordered_json layers = nlohmann::ordered_json::array();
  for (const SpectrogramLayer& layer : sizes.layers) {
    layers.push_back({{"filters", layer.filters},
                      {"kernel", {layer.kernel_bands, layer.kernel_frames}},
                      {"pool", {layer.pool_bands, layer.pool_frames}}});
  }
  json["sizes"] = {{"width", sizes.width},
                   {"layers", layers},
                   {"dropout", sizes.dropout},
                   {"fused", sizes.fused},
                   {"factors", sizes.factors}};
  const LearningOptions& learning = method.learning;
  json["learning"] = {{"epochs", learning.epochs},
                      {"patience", learning.patience},
                      {"batch", learning.batch},
                      {"learning_rate", learning.learning_rate},
                      {"schedule", name_of(learning.schedule)},
                      {"weight_decay", learning.weight_decay},
                      {"outliers", learning.outliers},
                      {"equaliser_db", learning.equaliser},
                      {"seed", learning.seed},
                      {"memory", learning.memory}};
  return json;
}

namespace {

/// Of one layer they stand among the sizes themselves in files of earlier versions.
std::vector<SpectrogramLayer> layers_from(const nlohmann::json& sizes) {
  std::vector<SpectrogramLayer> layers;
  for (const nlohmann::json& layer :
       sizes.contains("layers") ? sizes.at("layers") : nlohmann::json::array({sizes})) {
    layers.push_back({.filters = layer.at("filters"),
                      .kernel_bands = layer.at("kernel").at(0),
                      .kernel_frames = layer.at("kernel").at(1),
                      .pool_bands = layer.at("pool").at(0),
                      .pool_frames = layer.at("pool").at(1)});
  }
  return layers;
}

}  // namespace

Method method_from(const nlohmann::json& json) {
  Method method;
  method.name = json.at("name");
  method.kind = named(all_method_kinds, json.at("kind"));
  for (const std::string branch : json.at("branches")) {
    method.branches.push_back(named(all_branches, branch));
  }
  for (const std::string modality : json.at("modalities")) {
    method.modalities.push_back(named(all_modalities, modality));
  }
  method.fusion = named(all_fusions, json.at("fusion"));
  method.neighbours = json.at("neighbours");
  method.cost = json.value("cost", method.cost);
  const nlohmann::json& spectrogram = json.at("spectrogram");
  method.spectrogram = {named(all_spectrogram_scales, spectrogram.at("scale")),
                        spectrogram.at("range_db")};
  const nlohmann::json& sizes = json.at("sizes");
  method.sizes = {.width = sizes.at("width"),
                  .layers = layers_from(sizes),
                  .dropout = sizes.at("dropout"),
                  .fused = sizes.at("fused"),
                  .factors = sizes.at("factors")};
  const nlohmann::json& learning = json.at("learning");
  method.learning = {.epochs = learning.at("epochs"),
                     .patience = learning.at("patience"),
                     .batch = learning.at("batch"),
                     .learning_rate = learning.at("learning_rate"),
                     .schedule = named(all_schedules, learning.value("schedule", "plateau")),
                     .weight_decay = learning.at("weight_decay"),
                     .outliers = learning.at("outliers"),
                     .equaliser = learning.value("equaliser_db", 0.0),
                     .seed = learning.at("seed"),
                     .memory = learning.at("memory")};
  return method;
}

}  // namespace carillon::eval::learning
