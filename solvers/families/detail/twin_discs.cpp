#include "solvers/families/detail/twin_discs.hpp"

namespace carillon::solvers::families {
namespace {

/// Where the second disc's centre lies: apart from the first, so that a point of the common circle
/// has a disc.
double second_centre(const DiscGrid& disc) {
  return 4 * disc.circles.back();
}

Vec2 turned_over(const DiscGrid& disc, const Vec2& p) {
  return {second_centre(disc) - p.x(), p.y()};
}

}  // namespace

PlanarGrid twin_discs(const DiscGrid& disc) {
  PlanarGrid grid = disc_grid(disc);
  // The outermost circle's vertices come last.
  const std::int32_t own = grid.vertices - disc.around, all = grid.vertices;
  const std::size_t triangles = grid.triangles.size();
  for (std::size_t t = 0; t < triangles; ++t) {
    std::array<std::int32_t, 3> corners = grid.triangles[t];
    for (std::int32_t& vertex : corners) vertex += vertex < own ? all : 0;
    grid.triangles.push_back(corners);
  }
  grid.vertices = all + own;
  grid.point = [disc, triangles, of_one = grid.point](std::size_t t, const Eigen::Vector3d& b) {
    return t < triangles ? of_one(t, b) : turned_over(disc, of_one(t - triangles, b));
  };
  return grid;
}

TwinPlace on_twin(const DiscGrid& disc, const Vec2& chart) {
  const bool second = chart.x() > second_centre(disc) / 2;
  return {second ? turned_over(disc, chart) : chart, second};
}

}  // namespace carillon::solvers::families
