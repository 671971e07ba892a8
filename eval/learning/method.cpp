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

LearningOptions usual_learning(MethodKind kind) {
  LearningOptions options;
  if (kind == MethodKind::linear_svm) {
    options.learning_rate = 1;
    options.weight_decay = 1e-5;
  }
  return options;
}

nlohmann::ordered_json to_json(const Method& method) {
  nlohmann::ordered_json json = {{"name", method.name}, {"kind", name_of(method.kind)}};
  json["branches"] = nlohmann::json::array();
  for (const Branch branch : method.branches) json["branches"].push_back(name_of(branch));
  json["modalities"] = nlohmann::json::array();
  for (const Modality modality : method.modalities) json["modalities"].push_back(name_of(modality));
  json["fusion"] = name_of(method.fusion);
  json["neighbours"] = method.neighbours;
  json["spectrogram"] = {{"scale", name_of(method.spectrogram.scale)},
                         {"range_db", method.spectrogram.range}};
  const LayerSizes& sizes = method.sizes;
  json["sizes"] = {{"width", sizes.width},
                   {"filters", sizes.filters},
                   {"kernel", {sizes.kernel_bands, sizes.kernel_frames}},
                   {"pool", {sizes.pool_bands, sizes.pool_frames}},
                   {"dropout", sizes.dropout},
                   {"fused", sizes.fused},
                   {"factors", sizes.factors}};
  const LearningOptions& learning = method.learning;
  json["learning"] = {{"epochs", learning.epochs},
                      {"patience", learning.patience},
                      {"batch", learning.batch},
                      {"learning_rate", learning.learning_rate},
                      {"weight_decay", learning.weight_decay},
                      {"outliers", learning.outliers},
                      {"seed", learning.seed},
                      {"memory", learning.memory}};
  return json;
}

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
  const nlohmann::json& spectrogram = json.at("spectrogram");
  method.spectrogram = {named(all_spectrogram_scales, spectrogram.at("scale")),
                        spectrogram.at("range_db")};
  const nlohmann::json& sizes = json.at("sizes");
  method.sizes = {.width = sizes.at("width"),
                  .filters = sizes.at("filters"),
                  .kernel_bands = sizes.at("kernel").at(0),
                  .kernel_frames = sizes.at("kernel").at(1),
                  .pool_bands = sizes.at("pool").at(0),
                  .pool_frames = sizes.at("pool").at(1),
                  .dropout = sizes.at("dropout"),
                  .fused = sizes.at("fused"),
                  .factors = sizes.at("factors")};
  const nlohmann::json& learning = json.at("learning");
  method.learning = {.epochs = learning.at("epochs"),
                     .patience = learning.at("patience"),
                     .batch = learning.at("batch"),
                     .learning_rate = learning.at("learning_rate"),
                     .weight_decay = learning.at("weight_decay"),
                     .outliers = learning.at("outliers"),
                     .seed = learning.at("seed"),
                     .memory = learning.at("memory")};
  return method;
}

}  // namespace carillon::eval::learning
