#include "dataset/exporters/gltf_audio.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/error.hpp"

namespace carillon::dataset::exporters {

namespace {

using nlohmann::ordered_json;

/// The sample points as nodes of the surface, and the triangles between them.
struct SamplePoints {
  std::vector<std::int32_t> nodes;
  std::vector<std::uint32_t> indices;
};

SamplePoints sample_points(const solvers::modes::ModeSurface& surface, AudioPoints points) {
  solvers::modes::ModeSurface flat = surface;
  if (points == AudioPoints::corners) {
    // Corners come first among the nodes of a face.
    const auto per_face =
        static_cast<std::size_t>(solvers::elements::nodes_per_face(surface.order));
    flat.faces.clear();
    for (std::size_t f = 0; f < surface.faces.size(); f += per_face)
      flat.faces.insert(flat.faces.end(),
                        {surface.faces[f], surface.faces[f + 1], surface.faces[f + 2]});
    flat.order = 1;
  }
  SamplePoints samples;
  std::vector<std::int64_t> number(surface.nodes.size(), -1);
  for (const solvers::mesh::Triangle& triangle : solvers::modes::flatten(flat).triangles) {
    for (const std::int32_t node : triangle) {
      std::int64_t& own = number[static_cast<std::size_t>(node)];
      if (own < 0) {
        own = static_cast<std::int64_t>(samples.nodes.size());
        samples.nodes.push_back(node);
      }
      samples.indices.push_back(static_cast<std::uint32_t>(own));
    }
  }
  return samples;
}

/// A contact that is neither soft nor hard [s].
constexpr double usual_contact_time = 0.5e-3;

/// How loud a mode is, as gltf_audio() orders them.
double loudness(const solvers::mesh::SurfaceMesh& surface, const Eigen::VectorXd& shape,
                double omega, double decay_rate) {
  double all = 0, normal = 0;
  for (const solvers::mesh::Triangle& t : surface.triangles) {
    const auto at = [&](std::size_t i) { return surface.vertices[static_cast<std::size_t>(t[i])]; };
    const Vec3 area = (at(1) - at(0)).cross(at(2) - at(0)) / 2;
    const double size = area.norm();
    if (!(size > 0)) continue;
    Vec3 mean = Vec3::Zero();
    for (const std::int32_t node : t) mean += shape.segment<3>(3 * Eigen::Index{node}) / 3;
    all += size * mean.squaredNorm();
    normal += std::pow(mean.dot(area), 2) / size;
  }
  const double pulse = 1 / (1 + std::pow(omega * usual_contact_time / std::numbers::pi, 2));
  return all * normal * std::pow(omega * pulse, 2) / std::max(decay_rate, 1e-3);
}

ordered_json material_of(std::span<const synth::material::Material> materials) {
  if (materials.size() != 1) return nullptr;
  const synth::material::Material& one = materials.front();
  ordered_json json = {{"name", one.name},
                       {"density", one.elastic.density},
                       {"youngsModulus", one.elastic.youngs_modulus},
                       {"poissonRatio", one.elastic.poisson_ratio}};
  if (one.damping.kind == synth::damping::DampingKind::rayleigh &&
      one.damping.parameters.size() == 2) {
    json["alpha"] = one.damping.parameters[0];
    json["beta"] = one.damping.parameters[1];
  }
  return json;
}

/// Our axes in glTF's, (x, y, z) at (x, z, -y).
Eigen::Matrix3d gltf_turn() {
  Eigen::Matrix3d turn;
  turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return turn;
}

ordered_json mass_properties(const synth::surface::RigidBody& rigid) {
  const Vec3 centre = gltf_turn() * rigid.centre;
  Eigen::Matrix3d axes = gltf_turn() * rigid.axes;
  if (axes.determinant() < 0) axes.col(2) *= -1;
  const Eigen::Quaterniond turn(axes);
  return {{"mass", rigid.mass},
          {"centerOfMass", {centre.x(), centre.y(), centre.z()}},
          {"inertiaDiagonal", {rigid.inertia.x(), rigid.inertia.y(), rigid.inertia.z()}},
          {"inertiaOrientation", {turn.x(), turn.y(), turn.z(), turn.w()}}};
}

}  // namespace

GltfAudio gltf_audio(const solvers::modes::Modes& modes, std::span<const double> decay_rates,
                     std::span<const synth::material::Material> materials,
                     const synth::surface::RigidBody& rigid, AudioPoints points) {
  struct Ringing {
    double damped;  ///< angular frequency [rad/s]
    double decay_rate, loudness;
    Eigen::VectorXd shape;
  };
  const solvers::mesh::SurfaceMesh surface = solvers::modes::flatten(modes.surface);
  std::vector<Ringing> ringing;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const double d = decay_rates[i], squared = modes.eigenvalues[i] - d * d;
    if (!(squared > 0)) continue;
    Eigen::VectorXd shape = modes.shapes.of(static_cast<Eigen::Index>(i));
    const double omega = std::sqrt(modes.eigenvalues[i]);
    const double heard = loudness(surface, shape, omega, d);
    ringing.push_back({std::sqrt(squared), d, heard, std::move(shape)});
  }
  if (ringing.empty())
    throw core::InputError("no mode of the object rings",
                           "all are overdamped: another material, or a lower --min-frequency");
  std::stable_sort(ringing.begin(), ringing.end(), [](const Ringing& one, const Ringing& other) {
    return one.loudness > other.loudness;
  });
  const SamplePoints samples = sample_points(modes.surface, points);
  GltfAudio audio;
  audio.indices = samples.indices;
  for (const std::int32_t node : samples.nodes)
    audio.positions.push_back(to_gltf_axes(modes.surface.nodes[static_cast<std::size_t>(node)]));
  for (const Ringing& mode : ringing) {
    audio.frequencies.push_back(static_cast<float>(mode.damped / (2 * std::numbers::pi)));
    audio.decay_rates.push_back(static_cast<float>(mode.decay_rate));
    for (const std::int32_t node : samples.nodes)
      audio.shapes.push_back(to_gltf_axes(mode.shape.segment<3>(3 * Eigen::Index{node})));
  }
  audio.material = material_of(materials);
  audio.mass_properties = mass_properties(rigid);
  return audio;
}

}  // namespace carillon::dataset::exporters
