#pragma once

#include <Eigen/Core>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "render/maps/surface_map.hpp"

namespace carillon::synth::motion {

using SharedMap = std::shared_ptr<const render::maps::SurfaceMap>;

/// A map as a ball-shaped tip traces it.
struct TracedMap {
  std::vector<SharedMap> levels;  ///< level k: blurred over 2^k texels
  double deepest = 0;             ///< below the face [m]
};

/// Texels that TracedMaps keeps at the most, of all maps and levels.
inline constexpr std::size_t max_traced_texels = std::size_t{1} << 26;

/// Maps as tips trace them, made once for each map and radius: from motion to motion the same
/// bodies touch the same maps. Beyond max_traced_texels the oldest are dropped.
class TracedMaps {
 public:
  /// The map alone, without blur.
  SharedMap finest(const SharedMap& map, double radius);
  /// @param radius  of the tip [m], >= 0; of a normal map the integrated heights are traced
  /// @throws InputError  a radius that is negative or no number, no map
  std::shared_ptr<const TracedMap> of(const SharedMap& map, double radius);

 private:
  struct Made {
    SharedMap map;
    double radius = 0;
    std::shared_ptr<TracedMap> traced;
    std::size_t texels() const;
  };
  std::shared_ptr<TracedMap> made(const SharedMap& map, double radius);
  void drop_oldest();

  std::deque<Made> made_;  ///< the oldest first
};

/// A textured face as a ball-shaped tip traces it, at any width of blur: what the tip's patch of
/// contact, or the time between two samples, averages over.
class TracedFace {
 public:
  /// @param traced  the face's map
  /// @throws InputError  a face without axes or size
  TracedFace(const render::maps::TexturedFace& face, std::shared_ptr<const TracedMap> traced);

  /// Where a point of the body lies on the face; none where it lies beside it, or farther from it
  /// than the map is deep and 2 mm.
  std::optional<Eigen::Vector2d> place(const Vec3& point) const;

  /// Detail of the traced surface, averaged along both axes: a wave of length L is sinc(width /
  /// L)^4 as deep, so that curvatures of finer waves fall, too. Between the windows of 2^k texels
  /// in straight lines; a width below a texel is none.
  render::maps::SurfaceDetail detail(const Eigen::Vector2d& uv, double width) const;

  const render::maps::TexturedFace& face() const { return face_; }

 private:
  render::maps::TexturedFace face_;  ///< its map as it came
  std::shared_ptr<const TracedMap> traced_;
};

}  // namespace carillon::synth::motion
