#include "solvers/families/detail/profile.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace carillon::solvers::families {
namespace {

using Eigen::Vector2d;

double angle_between(const Vector2d& a, const Vector2d& b) {
  return std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
}

}  // namespace

void Profile::add(std::function<ProfilePoint(double)> point) {
  // Fine enough that chords and arcs differ by less than a millionth of their length.
  constexpr int steps = 512;
  double length = 0, turning = 0, tightest = std::numeric_limits<double>::infinity();
  ProfilePoint before = point(0);
  for (int i = 1; i <= steps; ++i) {
    const ProfilePoint now = point(static_cast<double>(i) / steps);
    const double chord = (now.at - before.at).norm();
    const double angle = angle_between(before.tangent, now.tangent);
    length += chord;
    turning += angle;
    if (angle > 1e-9) tightest = std::min(tightest, chord / angle);
    before = now;
  }
  segments_.push_back({std::move(point), length, turning, tightest});
}

Profile& Profile::line(const Vector2d& a, const Vector2d& b) {
  const Vector2d tangent = (b - a).normalized();
  add([a, b, tangent](double u) { return ProfilePoint{(1 - u) * a + u * b, tangent}; });
  return *this;
}

Profile& Profile::arc(const Vector2d& centre, const Vector2d& semi_axes, double from, double to) {
  add([=](double u) {
    const double angle = from + u * (to - from);
    const Vector2d direction(-semi_axes.x() * std::sin(angle), semi_axes.y() * std::cos(angle));
    return ProfilePoint{
        centre + Vector2d(semi_axes.x() * std::cos(angle), semi_axes.y() * std::sin(angle)),
        direction.normalized() * (to > from ? 1.0 : -1.0)};
  });
  return *this;
}

Profile& Profile::swing(const Vector2d& a, const Vector2d& b, bool flare) {
  const Vector2d step = b - a;
  add([=](double u) {
    const double fraction = flare ? u * u * u : u * u * (3 - 2 * u);
    const double slope = flare ? 3 * u * u : 6 * u * (1 - u);
    return ProfilePoint{a + Vector2d(fraction * step.x(), u * step.y()),
                        Vector2d(slope * step.x(), step.y()).normalized()};
  });
  return *this;
}

Profile& Profile::rounded(const std::vector<Vector2d>& points, double fraction) {
  Vector2d start = points.front();
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Vector2d in = (points[i] - points[i - 1]).normalized();
    const Vector2d out = (points[i + 1] - points[i]).normalized();
    const double turn = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
    const double reach =
        fraction * std::min((points[i] - points[i - 1]).norm(), (points[i + 1] - points[i]).norm());
    const double radius = reach / std::tan(std::abs(turn) / 2);
    const Vector2d first = points[i] - reach * in;
    if ((first - start).dot(in) > 1e-9 * radius) line(start, first);
    const Vector2d left(-in.y(), in.x());
    const Vector2d centre = first + (turn > 0 ? radius : -radius) * left;
    const Vector2d spoke = first - centre;
    const double from = std::atan2(spoke.y(), spoke.x());
    arc(centre, Vector2d::Constant(radius), from, from + turn);
    start = points[i] + reach * out;
  }
  line(start, points.back());
  return *this;
}

ProfilePoint Profile::point(double s) const {
  for (std::size_t i = 0; i + 1 < segments_.size(); ++i) {
    if (s <= segments_[i].length) return segments_[i].point(s / segments_[i].length);
    s -= segments_[i].length;
  }
  return segments_.back().point(std::min(1.0, s / segments_.back().length));
}

double Profile::length() const {
  double sum = 0;
  for (const auto& segment : segments_) sum += segment.length;
  return sum;
}

double Profile::tightest() const {
  double radius = std::numeric_limits<double>::infinity();
  for (const auto& segment : segments_) radius = std::min(radius, segment.tightest);
  return radius;
}

double Profile::largest_radius() const {
  double radius = 0;
  for (const auto& segment : segments_)
    for (int i = 0; i <= 64; ++i) radius = std::max(radius, segment.point(i / 64.0).at.x());
  return radius;
}

}  // namespace carillon::solvers::families
