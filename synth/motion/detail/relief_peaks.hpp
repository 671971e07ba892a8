#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/maps/surface_map.hpp"

namespace carillon::synth::motion {

/// Texels of a map that goes on for ever: columns [from_u, to_u), rows [from_v, to_v).
struct Texels {
  int from_u = 0, to_u = 0, from_v = 0, to_v = 0;

  bool empty() const { return from_u >= to_u || from_v >= to_v; }
  bool have(int u, int v) const { return u >= from_u && u < to_u && v >= from_v && v < to_v; }
};

/// Centre of a texel [m].
inline Eigen::Vector2d centre_of(const render::maps::SurfaceMap& map, int u, int v) {
  return {(u + 0.5) * map.texel, (v + 0.5) * map.texel};
}

/// Texels whose centres lie within [low, high] and on a face of this size [m].
Texels texels_within(const render::maps::SurfaceMap& map, const Eigen::Vector2d& size,
                     const Eigen::Vector2d& low, const Eigen::Vector2d& high);

/// Blocks of a relief's texels with the highest of each: a body that stays above that is not
/// looked at closer.
class ReliefPeaks {
 public:
  static constexpr int side = 8;  ///< of a block [texel]

  /// @param relief  a map with heights
  explicit ReliefPeaks(std::shared_ptr<const render::maps::SurfaceMap> relief);

  struct Block {
    Texels texels;
    double highest = 0;          ///< no texel's height is above [m]
    int peak_u = 0, peak_v = 0;  ///< where that is, but at the edges of a map that does not repeat
  };
  /// Blocks that these texels lie in, row by row; blocks at the edges may reach beyond them.
  std::vector<Block> blocks(const Texels& texels) const;

  /// At a texel's centre [m].
  double height(int u, int v) const;

  const render::maps::SurfaceMap& relief() const { return *relief_; }

 private:
  struct Peak {
    double height = 0;
    std::int8_t u = 0, v = 0;  ///< from the block's first texel
  };

  std::shared_ptr<const render::maps::SurfaceMap> relief_;
  int columns_, rows_;
  std::vector<Peak> peaks_;
  std::vector<double> heights_;  ///< of the map's own texels [m]
};

}  // namespace carillon::synth::motion
