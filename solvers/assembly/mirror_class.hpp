#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/elements/elastic.hpp"
#include "solvers/mesh/mirrored_part.hpp"

namespace carillon::solvers::assembly {

/// Displacement fields of one parity in each of a body's planes of symmetry: symmetric ones are
/// their own image, antisymmetric ones its negative. K and M couple no two classes, so each is a
/// problem of its own on the part beside the planes: in a plane symmetric fields have no
/// displacement along its normal, antisymmetric ones none within it.
struct MirrorClass {
  std::vector<mesh::MirrorPlane> planes;  ///< none: all fields, on the whole body
  unsigned antisymmetric = 0;             ///< bit k: in planes[k]
  mesh::Box box;                          ///< of the whole body [m]

  bool is_antisymmetric(std::size_t plane) const { return (antisymmetric >> plane & 1u) != 0; }
  /// Of the translations along x, y and z (0 to 2) and the rotations about axes through the box's
  /// middle (3 to 5), those in the class, ascending.
  std::vector<int> rigid_motions() const;
  /// Components that are zero at a point of the part, bit i for component i.
  std::uint8_t held_at(const Vec3& point) const;
  /// Of a component at the image of a point that lies below the planes of `image` (bits): what it
  /// is of that component in the part, 1 or -1.
  double sign(unsigned image, int component) const;
};

/// The classes of a part, one for each set of planes in which a class is antisymmetric.
std::vector<MirrorClass> mirror_classes(const mesh::MirroredPart& part);

/// The axes whose mirrors a material has: all of them unless its anisotropy couples shears beside
/// the plane to what is not one.
std::vector<int> mirrored_axes(std::span<const elements::Elastic> regions);

}  // namespace carillon::solvers::assembly
