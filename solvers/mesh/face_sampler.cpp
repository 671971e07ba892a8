#include "solvers/mesh/face_sampler.hpp"

#include <Eigen/Geometry>

#include "solvers/elements/quadrature.hpp"

namespace carillon::solvers::mesh {

FaceSampler::FaceSampler(int order, int points) {
  const auto& rule = elements::triangle_rule(points);
  for (std::size_t q = 0; q < rule.size(); ++q) {
    Eigen::Matrix<double, Eigen::Dynamic, 3> gradient;
    const Eigen::VectorXd values =
        elements::triangle_shape_functions(order, rule.barycentric[q], &gradient);
    shapes_.push_back({values, gradient.col(1) - gradient.col(0), gradient.col(2) - gradient.col(0),
                       rule.barycentric[q], rule.weights[q]});
  }
}

std::vector<FaceSample> FaceSampler::of(const TetMesh& mesh, std::size_t face) const {
  const auto per_face = shapes_.front().values.size();
  Eigen::Matrix3Xd nodes(3, per_face);
  for (Eigen::Index n = 0; n < per_face; ++n) {
    const auto node =
        mesh.faces[face * static_cast<std::size_t>(per_face) + static_cast<std::size_t>(n)];
    nodes.col(n) = mesh.nodes[static_cast<std::size_t>(node)];
  }
  std::vector<FaceSample> samples;
  samples.reserve(shapes_.size());
  for (const Shape& shape : shapes_) {
    const Vec3 first = nodes * shape.along_first, second = nodes * shape.along_second;
    samples.push_back(
        {nodes * shape.values, shape.weight * first.cross(second), shape.barycentric});
  }
  return samples;
}

}  // namespace carillon::solvers::mesh
