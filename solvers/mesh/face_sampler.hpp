#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh {

/// A point of a quadrature rule on a curved boundary face.
struct FaceSample {
  Vec3 point;                   ///< [m]
  Vec3 area;                    ///< outward normal times the point's share of the face [m^2]
  Eigen::Vector3d barycentric;  ///< with respect to the face's corners
};

/// The points of elements::triangle_rule(points) on faces of an order.
class FaceSampler {
 public:
  FaceSampler(int order, int points);
  std::vector<FaceSample> of(const TetMesh& mesh, std::size_t face) const;

 private:
  struct Shape {
    Eigen::VectorXd values, along_first, along_second;
    Eigen::Vector3d barycentric;
    double weight;
  };
  std::vector<Shape> shapes_;
};

}  // namespace carillon::solvers::mesh
