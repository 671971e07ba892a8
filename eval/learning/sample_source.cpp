#include "eval/learning/sample_source.hpp"

#include <fmt/format.h>

#include "core/error.hpp"

namespace carillon::eval::learning {

namespace {

const char* remedy(Sense sense) {
  switch (sense) {
    case Sense::voxels:
      return "build it with `voxels: {resolution: 30}`";
    case Sense::image:
      return "build it with `camera: {width: 256, height: 256}`";
    case Sense::touch:
      return "touch comes with a motion of a stylus (docs/touch.md)";
    default:
      return "sources are joined where their sounds have one sample rate, one length and one mel";
  }
}

}  // namespace

SenseLayout require_layout(const SampleSource& source, Sense sense) {
  const std::optional<SenseLayout> layout = source.layout(sense);
  if (layout) return *layout;
  throw core::InputError(fmt::format("{} has no {}", source.name(), name_of(sense)), remedy(sense));
}

}  // namespace carillon::eval::learning
