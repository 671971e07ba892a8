#include "synth/motion/detail/relief_peaks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace carillon::synth::motion {

using Eigen::Vector2d;

namespace {

constexpr int side = ReliefPeaks::side;

int blocks_along(int texels) {
  return (texels + side - 1) / side;
}

/// Texels [from, to) along one axis, in the block of this number.
struct Stretch {
  int from, to, block;
};

/// Blocks of a map that repeats end with each period; one that does not goes on with its edges.
std::vector<Stretch> stretches(int from, int to, int count, bool repeats) {
  std::vector<Stretch> result;
  if (!repeats) {
    const int first = static_cast<int>(std::floor(static_cast<double>(from) / side));
    for (int block = first; block * side < to; ++block) {
      result.push_back(
          {block * side, (block + 1) * side, std::clamp(block, 0, blocks_along(count) - 1)});
    }
    return result;
  }
  const int first = static_cast<int>(std::floor(static_cast<double>(from) / count));
  for (int begin = first * count; begin < to; begin += count) {
    for (int block = 0; block < blocks_along(count); ++block) {
      const int low = begin + block * side;
      const int high = std::min(low + side, begin + count);
      if (high > from && low < to) result.push_back({low, high, block});
    }
  }
  return result;
}

}  // namespace

Texels texels_within(const render::maps::SurfaceMap& map, const Vector2d& size, const Vector2d& low,
                     const Vector2d& high) {
  const Vector2d from = low.cwiseMax(Vector2d(0, 0)) / map.texel;
  const Vector2d to = high.cwiseMin(size) / map.texel;
  return {static_cast<int>(std::ceil(from.x() - 0.5)), static_cast<int>(std::floor(to.x() + 0.5)),
          static_cast<int>(std::ceil(from.y() - 0.5)), static_cast<int>(std::floor(to.y() + 0.5))};
}

ReliefPeaks::ReliefPeaks(std::shared_ptr<const render::maps::SurfaceMap> relief)
    : relief_(std::move(relief)),
      columns_(blocks_along(relief_->width)),
      rows_(blocks_along(relief_->height)) {
  peaks_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (Peak& peak : peaks_) peak.height = -std::numeric_limits<double>::infinity();
  // Where a map does not repeat its edges go on as they are, without what smooths them inside.
  const int beyond = relief_->repeats ? 0 : 1;
  for (int v = -beyond; v < relief_->height + beyond; ++v) {
    for (int u = -beyond; u < relief_->width + beyond; ++u) {
      const int row = std::clamp(v, 0, relief_->height - 1);
      const int column = std::clamp(u, 0, relief_->width - 1);
      const double height = render::maps::height_at(*relief_, centre_of(*relief_, u, v));
      if (row == v && column == u) heights_.push_back(height);
      Peak& peak = peaks_[static_cast<std::size_t>(row / side * columns_ + column / side)];
      if (!(height > peak.height)) continue;
      peak = {height, static_cast<std::int8_t>(column % side),
              static_cast<std::int8_t>(row % side)};
    }
  }
}

double ReliefPeaks::height(int u, int v) const {
  const int width = relief_->width, height = relief_->height;
  if (relief_->repeats) {
    u = u % width + (u % width < 0 ? width : 0);
    v = v % height + (v % height < 0 ? height : 0);
  } else if (u < 0 || v < 0 || u >= width || v >= height) {
    return render::maps::height_at(*relief_, centre_of(*relief_, u, v));
  }
  return heights_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(u)];
}

std::vector<ReliefPeaks::Block> ReliefPeaks::blocks(const Texels& texels) const {
  std::vector<Block> result;
  if (texels.empty()) return result;
  const auto across = stretches(texels.from_u, texels.to_u, relief_->width, relief_->repeats);
  for (const Stretch& v :
       stretches(texels.from_v, texels.to_v, relief_->height, relief_->repeats)) {
    for (const Stretch& u : across) {
      const Peak& peak = peaks_[static_cast<std::size_t>(v.block * columns_ + u.block)];
      result.push_back(
          {{u.from, u.to, v.from, v.to}, peak.height, u.from + peak.u, v.from + peak.v});
    }
  }
  return result;
}

}  // namespace carillon::synth::motion
