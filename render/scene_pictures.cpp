#include <algorithm>
#include <cmath>

#include "render/scene_frame.hpp"

namespace carillon::render {

core::ImageSamples depth_picture(const SceneFrame& frame, double unit) {
  core::ImageSamples picture{frame.color.width, frame.color.height, 1, 16, {}};
  picture.values.reserve(frame.depth.size());
  for (const float depth : frame.depth) {
    const double value = std::min(static_cast<double>(depth) / unit, 65535.0);
    picture.values.push_back(static_cast<std::uint16_t>(std::lround(value)));
  }
  return picture;
}

core::Image mask_picture(const SceneFrame& frame) {
  return {frame.color.width, frame.color.height, 1, frame.mask};
}

}  // namespace carillon::render
