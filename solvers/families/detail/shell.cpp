#include "solvers/families/detail/shell.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "solvers/families/extrude.hpp"
#include "solvers/mesh/sizing.hpp"

namespace carillon::solvers::families {
namespace {

/// Ends of the cells that a smooth piece of a profile is cut into: no longer than `cell`, shorter
/// where it bends.
/// @param from,to  coordinates s
std::vector<double> divide(const Profile& profile, double from, double to, double cell,
                           double wall) {
  constexpr int steps = 256;
  const auto place = [from, to](double step) { return from + (to - from) * step / steps; };
  std::vector<double> cumulated{0};
  ProfilePoint before = profile.point(from);
  for (int i = 1; i <= steps; ++i) {
    const ProfilePoint now = profile.point(place(i));
    const double chord = (now.at - before.at).norm();
    const double cosine = std::clamp(now.tangent.dot(before.tangent), -1.0, 1.0);
    const double angle = std::acos(cosine);
    const double longest =
        angle > 1e-7 ? std::min(cell, mesh::max_chord(chord / angle, wall)) : cell;
    cumulated.push_back(cumulated.back() + chord / longest);
    before = now;
  }
  const int count = std::max(1, static_cast<int>(std::ceil(cumulated.back() * (1 - 1e-9))));
  std::vector<double> ends;
  std::size_t at = 0;
  for (int k = 1; k < count; ++k) {
    const double goal = cumulated.back() * k / count;
    while (cumulated[at + 1] < goal) ++at;
    const double within = (goal - cumulated[at]) / (cumulated[at + 1] - cumulated[at]);
    ends.push_back(place(static_cast<double>(at) + within));
  }
  ends.push_back(to);
  return ends;
}

/// Ascending, without those that nearly coincide with others and would make slivers; the last
/// stays.
std::vector<double> distinct(std::vector<double> joints, const Shell& shell) {
  std::sort(joints.begin(), joints.end());
  const double minimum = 0.2 * shell.thinnest, last = joints.back();
  joints.erase(std::unique(joints.begin(), joints.end(),
                           [minimum](double a, double b) { return b - a < minimum; }),
               joints.end());
  joints.back() = last;
  return joints;
}

/// Places s where the wall's middle line or its thickness is not smooth, and its end.
std::vector<double> joints_of(const Shell& shell) {
  std::vector<double> joints = shell.wall_joints;
  double length = 0;
  for (const auto& segment : shell.profile.segments()) joints.push_back(length += segment.length);
  return distinct(std::move(joints), shell);
}

/// The disc whose radius is the profile's coordinate s, its circles at the wall's joints.
DiscGrid plan(const Shell& shell, double cell) {
  const double radius = shell.profile.largest_radius();
  const double around =
      2 * std::numbers::pi * radius / std::min(cell, mesh::max_chord(radius, shell.thinnest));
  const int around_by_four = std::max(3, static_cast<int>(std::ceil(around / 4 * (1 - 1e-9))));
  const std::vector<double> joints = joints_of(shell);
  DiscGrid disc = flat_disc(4 * around_by_four, joints.front(), cell);
  for (std::size_t i = 0; i + 1 < joints.size(); ++i)
    for (const double s : divide(shell.profile, joints[i], joints[i + 1], cell, shell.thinnest))
      disc.circles.push_back(s);
  return disc;
}

/// Point of the wall, t from one side to the other.
Vec2 wall_point(const Shell& shell, double s, double t) {
  const ProfilePoint middle = shell.profile.point(s);
  const Vec2 normal(middle.tangent.y(), -middle.tangent.x());
  return middle.at + (t - 0.5) * shell.wall(s) * normal;
}

}  // namespace

void check_shell(const mesh::GeneratedShape& shape, const Shell& shell) {
  require(shell.thickest <= 1.6 * shell.profile.tightest(), shape,
          fmt::format("a wall of {:.4g} m is too thick for a profile that bends with a radius of "
                      "{:.4g} m; it may be {:.4g} m",
                      shell.thickest, shell.profile.tightest(), 1.6 * shell.profile.tightest()));
}

mesh::MeshResult mesh_shell(const Shell& shell, const mesh::MeshOptions& options) {
  const auto count = [&](double cell) {
    return 6 * plan(shell, cell).cells() * mesh::layers_through(shell.thickest, cell, options);
  };
  const double cell =
      mesh::cell_size(options, shell.thickest,
                      std::max(shell.profile.length(), 2 * shell.profile.largest_radius()), count);
  const int layers = mesh::layers_through(shell.thickest, cell, options);
  return finish(extrude(disc_grid(plan(shell, cell)), layers, options.order,
                        [&shell](const Vec2& p, double t) {
                          const double s = p.norm();
                          const Vec2 at = wall_point(shell, s, t);
                          const Vec2 spoke = s > 0 ? Vec2(p / s) : Vec2(Vec2::Zero());
                          return Vec3(at.x() * spoke.x(), at.x() * spoke.y(), at.y());
                        }));
}

mesh::Meridian shell_meridian(const Shell& shell) {
  std::vector<double> joints = joints_of(shell);
  const double length = joints.back();
  joints.insert(joints.end(), {0, mesh::with_edge_layers(length, shell.wall(length)).rbegin()[1]});
  joints = distinct(std::move(joints), shell);
  if (joints.size() == 1) joints.insert(joints.begin(), 0);  // a wall thicker than it is long
  mesh::Meridian out;
  for (std::size_t i = 0; i + 1 < joints.size(); ++i) {
    const int corner = 2 * static_cast<int>(i);
    const double from = joints[i], to = joints[i + 1];
    out.blocks.push_back(
        {{corner, corner + 2, corner + 3, corner + 1}, [shell, from, to](double u, double v) {
           return wall_point(shell, (1 - u) * from + u * to, v);
         }});
  }
  return out;
}

}  // namespace carillon::solvers::families
