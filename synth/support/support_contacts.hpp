#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "synth/modal/ring_down.hpp"

namespace carillon::synth::support {

/// A place where a support touches the body.
struct Contact {
  modal::SurfacePoint point;
  Vec3 normal;          ///< unit vector of the contact; its sign does not matter
  double fraction = 1;  ///< of the support's force; the fractions of one support sum to 1
  double area = 0;      ///< that it stands for [m^2]; 0: a point
};

/// One point, with the surface's own normal.
std::vector<Contact> point_contact(const solvers::modes::ModeSurface& surface,
                                   const modal::SurfacePoint& point);

/// What lies within `radius` [m] of a point of the outer surface and faces the same side as it (a
/// finger touches one side of a thin wall), under even pressure: force in proportion to area. The
/// point itself when the radius is 0.
/// @param triangles  outer_pieces(surface)
/// @throws InputError  a radius that is negative or not finite
std::vector<Contact> patch_contacts(const solvers::modes::ModeSurface& surface,
                                    std::span<const surface::SurfaceTriangle> triangles,
                                    const modal::SurfacePoint& centre, double radius);

/// Where a body that stands or lies as it is touches the ground: the parts of the outer surface
/// that look down and lie within `height` [m] of its lowest point, under even pressure, all with
/// the ground's normal. When nothing there looks down (a blade on its edge), the lowest node.
/// @param down  unit vector
/// @throws InputError  a height that is negative or not finite, a direction of no unit length
std::vector<Contact> lowest_contacts(const solvers::modes::ModeSurface& surface, const Vec3& down,
                                     double height);

/// Along a polyline [m]: `points` places evenly spaced in length, each moved to the nearest point
/// of the outer surface, with equal shares.
/// @param sampler  of `surface`
/// @throws InputError  no corners, a corner that is not finite, no points
std::vector<Contact> edge_contacts(const solvers::modes::ModeSurface& surface,
                                   const modal::SurfaceSampler& sampler,
                                   std::span<const Vec3> polyline, int points);

/// All that touches [m^2].
double area_of(std::span<const Contact> contacts);

/// Mean position of contacts, weighted by their shares [m].
Vec3 centre_of(const solvers::modes::ModeSurface& surface, std::span<const Contact> contacts);

}  // namespace carillon::synth::support
