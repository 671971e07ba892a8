#pragma once

#include <string>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh {

/// What a surface is whatever its place, turn, size, numbering, welding and names: sizes of its
/// surface moments up to the sixth degree, of one length. No axes are chosen, so that a sphere or a
/// cube is as good as a body whose principal axes are distinct. Mirror images are the same: they
/// ring alike.
///
/// The moments are integrals over the area: a face cut into smaller ones, turned over, doubled, or
/// with corners of its own changes nothing. Empty where the surface has no area.
using ShapeSignature = std::vector<double>;

/// @param mesh  any unit of length
ShapeSignature shape_signature(const SurfaceMesh& mesh);

/// Largest difference of two signatures: about that of the surfaces, as a fraction of their size;
/// infinite where one is empty.
double signature_difference(const ShapeSignature& a, const ShapeSignature& b);

/// Difference up to which two surfaces are the same shape: what is left of a body that was turned
/// and written with six digits.
inline constexpr double same_shape_tolerance = 1e-5;

/// Names a signature to two thousandths: equal for nearly all pairs of the same shape (those at a
/// border of the grid differ), and for few others. "" for an empty one.
std::string signature_name(const ShapeSignature& signature);

/// Finds signatures of the same shape among those added so far, without comparing all pairs.
class SignatureIndex {
 public:
  /// @return number (from 0, in the order of adding) of the first that is the same; its own where
  ///         there is none. An empty signature is like no other.
  std::size_t add(const ShapeSignature& signature);

 private:
  std::vector<ShapeSignature> all_;
  std::vector<std::size_t> sorted_;  ///< those that are like none before, by their first value
};

}  // namespace carillon::solvers::mesh
