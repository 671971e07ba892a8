#include "eval/learning/sample_source.hpp"

#include <fmt/format.h>

#include "core/error.hpp"

namespace carillon::eval::learning {

namespace {

const char* remedy(Modality modality) {
  switch (modality) {
    case Modality::voxels:
      return "build it with `voxels: {resolution: 30}`";
    case Modality::image:
      return "build it with `camera: {width: 256, height: 256}`; one whose index.h5 has "
             "shapes/frame "
             "is of an older version, which drew each object in one material alone: build it anew";
    case Modality::touch:
      return "touch comes with a motion of a stylus (docs/touch.md)";
    default:
      return "sources are joined where their sounds have one sample rate, one length and one mel";
  }
}

}  // namespace

ModalityLayout require_layout(const SampleSource& source, Modality modality) {
  const std::optional<ModalityLayout> layout = source.layout(modality);
  if (layout) return *layout;
  throw core::InputError(fmt::format("{} has no {}", source.name(), name_of(modality)),
                         remedy(modality));
}

}  // namespace carillon::eval::learning
