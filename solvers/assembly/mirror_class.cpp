#include "solvers/assembly/mirror_class.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace carillon::solvers::assembly {

std::vector<int> MirrorClass::rigid_motions() const {
  std::vector<int> out;
  for (int motion = 0; motion < 6; ++motion) {
    bool inside = true;
    for (std::size_t p = 0; p < planes.size(); ++p) {
      // A translation along the normal is turned round, a rotation about it is not.
      const bool along = planes[p].axis == motion % 3;
      const bool turned = motion < 3 ? along : !along;
      inside = inside && turned == is_antisymmetric(p);
    }
    if (inside) out.push_back(motion);
  }
  return out;
}

std::uint8_t MirrorClass::held_at(const Vec3& point) const {
  constexpr double in_plane = 1e-9;
  constexpr unsigned all = 7;
  unsigned held = 0;
  for (std::size_t p = 0; p < planes.size(); ++p) {
    const auto& plane = planes[p];
    if (std::abs(point[plane.axis] - plane.position) > in_plane * box.longest_side()) continue;
    const unsigned normal = 1u << plane.axis;
    held |= is_antisymmetric(p) ? all & ~normal : normal;
  }
  return static_cast<std::uint8_t>(held);
}

double MirrorClass::sign(unsigned image, int component) const {
  double out = 1;
  for (std::size_t p = 0; p < planes.size(); ++p) {
    if ((image >> p & 1u) == 0) continue;
    if (planes[p].axis == component) out = -out;
    if (is_antisymmetric(p)) out = -out;
  }
  return out;
}

std::vector<MirrorClass> mirror_classes(const mesh::MirroredPart& part) {
  std::vector<MirrorClass> out;
  for (unsigned bits = 0; bits < part.image_count(); ++bits)
    out.push_back({part.planes, bits, part.box});
  return out;
}

std::vector<int> mirrored_axes(std::span<const elements::Elastic> regions) {
  // Shears of Voigt's order 23, 13, 12 change sign where one of their two axes does.
  constexpr std::array<std::array<bool, 6>, 3> turned = {
      {{false, false, false, false, true, true},
       {false, false, false, true, false, true},
       {false, false, false, true, true, false}}};
  constexpr double rounding = 1e-12;
  std::vector<int> out;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& turns = turned[static_cast<std::size_t>(axis)];
    const bool mirrored =
        std::all_of(regions.begin(), regions.end(), [&](const elements::Elastic& region) {
          if (!region.anisotropy) return true;
          const auto& stiffness = *region.anisotropy;
          for (Eigen::Index i = 0; i < 6; ++i) {
            for (Eigen::Index j = 0; j < 6; ++j) {
              const bool couples =
                  turns[static_cast<std::size_t>(i)] != turns[static_cast<std::size_t>(j)];
              if (couples && std::abs(stiffness(i, j)) > rounding * stiffness.cwiseAbs().maxCoeff())
                return false;
            }
          }
          return true;
        });
    if (mirrored) out.push_back(axis);
  }
  return out;
}

}  // namespace carillon::solvers::assembly
