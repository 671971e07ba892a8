#include "synth/radiation/detail/source_layers.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "synth/modal/readout.hpp"
#include "synth/surface/point_flux.hpp"

namespace carillon::synth::radiation {

namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// Depth of the sources: this fraction of the distance between layers, and of the largest ball
/// inside that touches the surface there, so that walls hold them in their middle and edges are not
/// met.
constexpr double depth_of_spacing = 0.5;
constexpr double depth_of_ball = 0.8;
/// Flux between patches nearer than this many times their spacing is exact.
constexpr double near_limit = 2;
/// A point stands for its triangle: it is smeared out over this fraction of the area's square root.
constexpr double core_fraction = 0.3;
/// The mean of 1/r over pairs of points of a disc is 16 / (3 pi radius); 1 / this fraction of the
/// square root of its area gives the same.
constexpr double softening = 0.333;
/// In which power is taken.
constexpr int direction_count = 200;

double monopole_flux(const Vec3& from_source, const Vec3& area) {
  const double r = from_source.norm();
  return -from_source.dot(area) / (4 * pi * r * r * r);
}

double dipole_flux(const Vec3& from_source, const Vec3& area, const Vec3& direction) {
  const double r2 = from_source.squaredNorm();
  const double r3 = r2 * std::sqrt(r2);
  return (area.dot(direction) - 3 * from_source.dot(area) * from_source.dot(direction) / r2) /
         (4 * pi * r3);
}

/// Static flux through patches: by points where they are far apart, exact where they are near.
void add_static_flux(const surface::OuterTriangles& surface, SourceLayers& layers) {
  const surface::SurfacePatches& patches = layers.patches;
  const auto count = static_cast<Eigen::Index>(patches.size());
  Eigen::MatrixXd far_dipoles = Eigen::MatrixXd::Zero(count, count);
  Eigen::MatrixXd far_monopoles = far_dipoles;
  layers.static_dipoles = Eigen::MatrixXd::Zero(count, layers.strengths.cols());
  layers.static_monopoles = layers.static_dipoles;
  const auto corner = [&](int vertex, const Vec3& point) {
    return Vec3(surface.mesh.vertices[static_cast<std::size_t>(vertex)] - point);
  };
  for (Eigen::Index row = 0; row < count; ++row) {
    const auto i = static_cast<std::size_t>(row);
    Vec3 area = Vec3::Zero();
    for (const int t : patches.members[i])
      area += surface.area_vectors[static_cast<std::size_t>(t)];
    for (Eigen::Index column = 0; column < count; ++column) {
      const auto j = static_cast<std::size_t>(column);
      const double distance = (patches.centres[i] - patches.centres[j]).norm();
      const bool near = distance < near_limit * patches.spacing ||
                        distance < patches.radii[i] + patches.radii[j] + patches.spacing;
      if (!near) {
        const Vec3 way = patches.centres[i] - layers.patch_points[j];
        far_dipoles(row, column) = dipole_flux(way, area, patches.normals[j]);
        far_monopoles(row, column) = monopole_flux(way, area);
        continue;
      }
      for (const int t : patches.members[j]) {
        const Vec3& point = layers.points[static_cast<std::size_t>(t)];
        const double core = core_fraction * std::sqrt(surface.areas[static_cast<std::size_t>(t)]);
        double angle = 0;
        for (const int u : patches.members[i]) {
          const auto& c = surface.mesh.triangles[static_cast<std::size_t>(u)];
          angle += solvers::mesh::solid_angle(corner(c[0], point), corner(c[1], point),
                                              corner(c[2], point));
        }
        Vec3 gradient = Vec3::Zero();
        for (const auto& [a, b] : patches.outline[i]) {
          gradient += surface::solid_angle_gradient(corner(a, point), corner(b, point), core);
        }
        const double dipole =
            -gradient.dot(layers.directions[static_cast<std::size_t>(t)]) / (4 * pi);
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(layers.strengths, t);
             entry; ++entry) {
          layers.static_dipoles(row, entry.col()) += dipole * entry.value();
          layers.static_monopoles(row, entry.col()) += -angle / (4 * pi) * entry.value();
        }
      }
    }
  }
  layers.static_dipoles += far_dipoles * layers.patch_strengths;
  layers.static_monopoles += far_monopoles * layers.patch_strengths;
}

/// (1 + z) exp(-z) - 1 and (3 + 3 z + z^2) exp(-z) - 3 for z = i x: what the wave adds to the
/// static gradient and to its gradient. In real numbers: the products of complex ones check for
/// infinities, which costs more than all the rest.
struct WaveParts {
  double first_real, first_imag, second_real, second_imag;
};

WaveParts wave_parts(double x) {
  const double x2 = x * x;
  if (x < 0.02) {
    return {x2 / 2 - x2 * x2 / 8, -x2 * x / 3, x2 / 2 + x2 * x2 / 8, -x2 * x2 * x / 15};
  }
  const double sine = std::sin(x), cosine = std::cos(x);
  return {cosine + x * sine - 1, x * cosine - sine, (3 - x2) * cosine + 3 * x * sine - 3,
          3 * x * cosine - (3 - x2) * sine};
}

}  // namespace

SourceLayers source_layers(const surface::OuterTriangles& surface, std::size_t patches,
                           std::size_t count) {
  SourceLayers layers;
  layers.patches = surface::surface_patches(surface, patches);
  layers.strengths = surface::smooth_functions(surface, count);
  const std::vector<double> radii = surface::inscribed_radii(surface, layers.patches);
  const double spacing = std::sqrt(surface.area / static_cast<double>(layers.strengths.cols()));
  Vec3 middle = Vec3::Zero();
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const Vec3 normal =
        surface.areas[t] > 0 ? Vec3(surface.area_vectors[t] / surface.areas[t]) : Vec3::Zero();
    const double depth = std::min(depth_of_spacing * spacing, depth_of_ball * radii[t]);
    layers.points.push_back(surface.centres[t] - depth * normal);
    layers.directions.push_back(normal);
    middle += surface.areas[t] / surface.area * layers.points[t];
  }
  for (const Vec3& point : layers.points) {
    layers.size = std::max(layers.size, (point - middle).norm());
  }
  for (Eigen::Index t = 0; t < layers.strengths.rows(); ++t) {
    layers.strengths.row(t) *= surface.areas[static_cast<std::size_t>(t)];
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t patch = 0; patch < layers.patches.size(); ++patch) {
    Vec3 point = Vec3::Zero();
    for (const int t : layers.patches.members[patch]) {
      entries.emplace_back(static_cast<int>(patch), t, 1.0);
      const auto triangle = static_cast<std::size_t>(t);
      point += surface.areas[triangle] / layers.patches.areas[patch] * layers.points[triangle];
    }
    layers.patch_points.push_back(point);
  }
  Eigen::SparseMatrix<double> sums(static_cast<Eigen::Index>(layers.patches.size()),
                                   static_cast<Eigen::Index>(surface.size()));
  sums.setFromTriplets(entries.begin(), entries.end());
  layers.patch_strengths = sums * Eigen::SparseMatrix<double>(layers.strengths);
  add_static_flux(surface, layers);
  return layers;
}

Eigen::MatrixXcd layer_fluxes(const SourceLayers& layers, double wavenumber) {
  const surface::SurfacePatches& patches = layers.patches;
  const auto count = static_cast<Eigen::Index>(patches.size());
  const Complex monopoles(1 / layers.size, wavenumber);
  Eigen::MatrixXd wave_real(count, count), wave_imag(count, count);
  for (Eigen::Index column = 0; column < count; ++column) {
    const auto j = static_cast<std::size_t>(column);
    const Vec3& direction = patches.normals[j];
    for (Eigen::Index row = 0; row < count; ++row) {
      const auto i = static_cast<std::size_t>(row);
      const Vec3 way = patches.centres[i] - layers.patch_points[j];
      const double r = std::sqrt(way.squaredNorm() + softening * softening * patches.areas[i]);
      const double along = way.dot(patches.normals[i]) / r;
      const double across = patches.normals[i].dot(direction);
      const WaveParts wave_part = wave_parts(wavenumber * r);
      const double turned = along * way.dot(direction) / r;
      const double scale = patches.areas[i] / (4 * pi * r * r);
      const double real =
          (wave_part.first_real * across - wave_part.second_real * turned) / r -
          along * (monopoles.real() * wave_part.first_real - wavenumber * wave_part.first_imag);
      const double imag =
          (wave_part.first_imag * across - wave_part.second_imag * turned) / r -
          along * (monopoles.real() * wave_part.first_imag + wavenumber * wave_part.first_real);
      wave_real(row, column) = scale * real;
      wave_imag(row, column) = scale * imag;
    }
  }
  Eigen::MatrixXcd fluxes(count, layers.patch_strengths.cols());
  fluxes.real() = wave_real * layers.patch_strengths + layers.static_dipoles +
                  monopoles.real() * layers.static_monopoles;
  fluxes.imag() = wave_imag * layers.patch_strengths + monopoles.imag() * layers.static_monopoles;
  return fluxes;
}

Eigen::VectorXd radiated_power(const SourceLayers& layers, double wavenumber,
                               const Eigen::MatrixXcd& strengths) {
  const auto count = static_cast<Eigen::Index>(layers.patch_points.size());
  // Far away a dipole is i k cos(angle) of a monopole.
  const Complex monopoles(1 / layers.size, wavenumber);
  Eigen::MatrixXcd rays(direction_count, count);
  for (int i = 0; i < direction_count; ++i) {
    // Points of a spiral (Saff and Kuijlaars 1997), equal in area.
    const double z = 1 - (2 * i + 1.0) / direction_count;
    const double turn = pi * (3 - std::sqrt(5.0)) * i;
    const double across = std::sqrt(1 - z * z);
    const Vec3 way(across * std::cos(turn), across * std::sin(turn), z);
    for (Eigen::Index j = 0; j < count; ++j) {
      const auto patch = static_cast<std::size_t>(j);
      const double phase = wavenumber * way.dot(layers.patch_points[patch]);
      const Complex strength =
          monopoles + Complex(0, wavenumber * way.dot(layers.patches.normals[patch]));
      rays(i, j) = strength * Complex(std::cos(phase), std::sin(phase));
    }
  }
  const Eigen::MatrixXcd pressures = rays * (layers.patch_strengths * strengths);
  // |p|^2 r^2 / (2 rho c) over the sphere, p r = sum / (4 pi).
  return pressures.colwise().squaredNorm().transpose() /
         (8 * pi * modal::air_density * modal::speed_of_sound * direction_count);
}

}  // namespace carillon::synth::radiation
