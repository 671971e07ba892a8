#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "synth/surface/surface_patches.hpp"

namespace carillon::synth::radiation {

/// Smooth layers of point sources behind a closed surface, and what they send through its patches.
/// A layer's field is that of dipoles along the outward normal and of 1 / size + i k times as many
/// monopoles, with the field exp(-i k r) / (4 pi r) of a monopole.
struct SourceLayers {
  surface::SurfacePatches patches;
  double size = 0;               ///< radius of the sphere about the sources that holds them [m]
  std::vector<Vec3> points;      ///< of every triangle's source [m]
  std::vector<Vec3> directions;  ///< of its dipole, unit vectors
  /// Area of each point's triangle times each layer's strength there, points x layers [m^2].
  Eigen::SparseMatrix<double, Eigen::RowMajor> strengths;

  // The same in one point for each patch, for what is smooth between patches.
  std::vector<Vec3> patch_points;
  Eigen::SparseMatrix<double> patch_strengths;  ///< patches x layers [m^2]

  /// Flux of the static field's gradient through the patches, patches x layers.
  Eigen::MatrixXd static_dipoles;    ///< [m]
  Eigen::MatrixXd static_monopoles;  ///< [m^2]
};

/// @param patches  of the surface, more than there are layers
SourceLayers source_layers(const surface::OuterTriangles& surface, std::size_t patches,
                           std::size_t layers);

/// Flux of the gradient of every layer's field through every patch, patches x layers.
/// @param wavenumber  k >= 0 [1/m]
Eigen::MatrixXcd layer_fluxes(const SourceLayers& layers, double wavenumber);

/// Power that layers of given strengths send out, one value for each column.
/// @param strengths   layers x cases [Pa, as p = field x strength]
/// @param wavenumber  k >= 0 [1/m]
/// @return [W], from 200 directions spread evenly
Eigen::VectorXd radiated_power(const SourceLayers& layers, double wavenumber,
                               const Eigen::MatrixXcd& strengths);

}  // namespace carillon::synth::radiation
