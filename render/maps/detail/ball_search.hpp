#pragma once

#include <vector>

#include "render/maps/surface_map.hpp"

namespace carillon::render::maps {

/// Where a ball of one radius touches a relief, for places in a part of it: heights at the texels'
/// centres and the highest of each block of them, so that blocks that cannot be touched are passed
/// over unseen.
class BallSearch {
 public:
  /// How far from its centre a ball can touch [m]: no farther than a texel at `highest` would hold
  /// it up above a place of height `lowest`.
  static double reach(double radius, double lowest, double highest);

  /// For places in the texels columns [first_column, last_column) and rows, which may lie beyond
  /// the map's edges, with as much around them as a ball reaches.
  BallSearch(const SurfaceMap& relief, double radius, double reach, const Eigen::Array2i& first,
             const Eigen::Array2i& last);

  /// Height of the ball's lowest point above uv.
  /// @param contact  in: a place where it may well touch, which saves work and changes nothing;
  ///                 out: where it does
  double height(const Eigen::Vector2d& uv, Eigen::Vector2d& contact) const;

 private:
  double lift(double square) const;
  double value(const Eigen::Vector2d& uv, const Eigen::Vector2d& contact) const;
  double climb(const Eigen::Vector2d& uv, Eigen::Vector2d& contact) const;

  const SurfaceMap& relief_;
  double radius_;
  Eigen::Array2i first_;  ///< texel of the first height
  int width_ = 0, height_ = 0, blocks_across_ = 0;
  std::vector<float> heights_, blocks_;
  double highest_ = 0;
};

}  // namespace carillon::render::maps
