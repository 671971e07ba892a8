#pragma once

#include "solvers/families/extrude.hpp"

namespace carillon::solvers::families {

/// Two discs whose outermost circles are one, for walls of revolution that close around a hollow.
/// Its plane points are those of the discs, of the second one turned over beside the first.
PlanarGrid twin_discs(const DiscGrid& disc);

/// Where a plane point of twin_discs() is on its disc, and which it is.
struct TwinPlace {
  Vec2 at;
  bool on_second = false;
};
TwinPlace on_twin(const DiscGrid& disc, const Vec2& chart);

}  // namespace carillon::solvers::families
