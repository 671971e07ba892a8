#include "eval/learning/known_methods.hpp"

namespace carillon::eval::learning {

namespace {

Method network(const char* name, std::vector<Branch> branches,
               Fusion fusion = Fusion::concatenate) {
  Method method;
  method.name = name;
  method.branches = std::move(branches);
  method.fusion = fusion;
  for (const Branch branch : method.branches) method.modalities.push_back(modality_of(branch));
  return method;
}

Method baseline(const char* name, MethodKind kind, std::vector<Modality> modalities) {
  Method method;
  method.name = name;
  method.kind = kind;
  method.modalities = std::move(modalities);
  return method;
}

}  // namespace

std::span<const Method> known_methods() {
  static const std::vector<Method> methods = {
      network("isnn-a", {Branch::isnn}),
      network("soundnet5", {Branch::soundnet5}),
      network("soundnet8", {Branch::soundnet8}),
      network("voxnet", {Branch::voxnet}),
      network("isnn-av-concatenate", {Branch::isnn, Branch::voxnet}, Fusion::concatenate),
      network("isnn-av-add", {Branch::isnn, Branch::voxnet}, Fusion::add),
      network("isnn-av-multiply", {Branch::isnn, Branch::voxnet}, Fusion::multiply),
      network("isnn-av-bilinear", {Branch::isnn, Branch::voxnet}, Fusion::bilinear),
      network("soundnet8-av-concatenate", {Branch::soundnet8, Branch::voxnet}, Fusion::concatenate),
      network("soundnet8-av-add", {Branch::soundnet8, Branch::voxnet}, Fusion::add),
      network("soundnet8-av-multiply", {Branch::soundnet8, Branch::voxnet}, Fusion::multiply),
      network("soundnet8-av-bilinear", {Branch::soundnet8, Branch::voxnet}, Fusion::bilinear),
      network("image", {Branch::image}),
      network("touch", {Branch::touch}),
      network("isnn-image", {Branch::isnn, Branch::image}, Fusion::bilinear),
      network("isnn-touch", {Branch::isnn, Branch::touch}, Fusion::bilinear),
      network("image-touch", {Branch::image, Branch::touch}, Fusion::bilinear),
      network("isnn-image-touch", {Branch::isnn, Branch::image, Branch::touch}, Fusion::bilinear),
      baseline("nearest-neighbour-a", MethodKind::nearest_neighbour, {Modality::spectrogram}),
      baseline("nearest-neighbour-v", MethodKind::nearest_neighbour, {Modality::voxels}),
      baseline("nearest-neighbour-av", MethodKind::nearest_neighbour,
               {Modality::spectrogram, Modality::voxels}),
      baseline("linear-svm-a", MethodKind::linear_svm, {Modality::spectrogram}),
      baseline("linear-svm-v", MethodKind::linear_svm, {Modality::voxels}),
      baseline("linear-svm-av", MethodKind::linear_svm, {Modality::spectrogram, Modality::voxels})};
  return methods;
}

}  // namespace carillon::eval::learning
