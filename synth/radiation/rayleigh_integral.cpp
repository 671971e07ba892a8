#include "synth/radiation/rayleigh_integral.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "synth/surface/outer_surface.hpp"
#include "synth/surface/outer_triangles.hpp"
#include "synth/surface/surface_patches.hpp"

namespace carillon::synth::radiation {

namespace {

constexpr double points_per_wavelength = 8;
constexpr double min_triangles = 4000;
constexpr double max_triangles = 40000;
/// A triangle belongs to a face when its normal is this near to the sheet's.
constexpr double face_cosine = 0.9;

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double size() const { return std::max(0.0, high - low); }
};

struct Sheet {
  surface::OuterTriangles surface;
  Vec3 normal;
  double low, high;       ///< heights of its two faces along the normal [m]
  std::vector<int> side;  ///< of each triangle: 1 or -1 by its face, 0 on the rim
  double spacing;         ///< of the triangles [m]
};

Sheet flat_sheet(const solvers::modes::ModeSurface& body, std::size_t triangles) {
  Sheet sheet{surface::outer_triangles(body, triangles), Vec3::Zero(), 0, 0, {}, 0};
  const surface::OuterTriangles& surface = sheet.surface;
  Vec3 middle = Vec3::Zero();
  for (std::size_t t = 0; t < surface.size(); ++t) {
    middle += surface.areas[t] / surface.area * surface.centres[t];
  }
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const Vec3 way = surface.centres[t] - middle;
    spread += surface.areas[t] / surface.area * way * way.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  std::array<Extent, 3> extents;
  for (const Vec3& vertex : surface.mesh.vertices) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extents[axis].add(axes.eigenvectors().col(static_cast<Eigen::Index>(axis)).dot(vertex));
    }
  }
  sheet.normal = axes.eigenvectors().col(0);
  const double width = std::min(extents[1].size(), extents[2].size());

  std::array<Extent, 2> heights;  // of the faces against and along the normal
  sheet.side.assign(surface.size(), 0);
  double on_faces = 0;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const double cosine = surface.area_vectors[t].dot(sheet.normal);
    if (std::abs(cosine) < face_cosine * surface.areas[t] || !(surface.areas[t] > 0)) continue;
    sheet.side[t] = cosine > 0 ? 1 : -1;
    on_faces += surface.areas[t];
    for (const int corner : surface.mesh.triangles[t]) {
      heights[cosine > 0 ? 1 : 0].add(
          sheet.normal.dot(surface.mesh.vertices[static_cast<std::size_t>(corner)]));
    }
  }
  const double unevenness = std::max(heights[0].size(), heights[1].size());
  if (!(extents[0].size() <= sheet_thickness * width) || !(unevenness <= sheet_flatness * width) ||
      on_faces < 0.8 * surface.area) {
    throw core::InputError(
        fmt::format(
            "the object is not a flat sheet: {:.3g} m thick with any bulge and {:.3g} m wide "
            "(a sheet is at most {:.0f} % as thick as it is wide), faces flat to {:.3g} m "
            "(at most {:.1f} % of the width)",
            extents[0].size(), width, 100 * sheet_thickness, unevenness, 100 * sheet_flatness),
        "radiation: {model: equivalent_sources} takes objects of any shape");
  }
  sheet.low = heights[0].low;
  sheet.high = heights[1].high;
  sheet.spacing = std::sqrt(2 * surface.area / static_cast<double>(surface.size()));
  return sheet;
}

/// Which face a listener hears: 1 or -1.
int heard_side(const Sheet& sheet, const Vec3& position, std::size_t row) {
  if (!position.allFinite()) {
    throw core::InputError(fmt::format("listener {}: position is not finite", row));
  }
  const double height = sheet.normal.dot(position);
  const double slack = 1e-9 * sheet.spacing;
  if (height > sheet.low + slack && height < sheet.high - slack) {
    throw core::InputError(fmt::format("listener {} is between the two faces of the baffle", row),
                           "place it in front of the sheet or behind it");
  }
  const int side = height >= sheet.high - slack ? 1 : -1;
  const double distance = surface::distance_from(sheet.surface.mesh, position);
  if (!(distance >= sheet.spacing)) {
    throw core::InputError(
        fmt::format("listener {} is {:.4g} m off the sheet, whose points of integration are "
                    "{:.4g} m apart",
                    row, distance, sheet.spacing),
        fmt::format("move the listener at least {:.4g} m away", sheet.spacing));
  }
  return side;
}

}  // namespace

ModalPressure rayleigh_pressure(const solvers::modes::Modes& modes,
                                std::span<const modal::Listener> listeners) {
  const std::vector<double> k = wavenumbers(modes);
  const double highest = k.empty() ? 0 : *std::max_element(k.begin(), k.end());
  const double per_metre = points_per_wavelength * highest / (2 * std::numbers::pi);
  const double area = surface::outer_triangles(modes.surface, 1).area;
  const double wanted = std::clamp(2 * area * per_metre * per_metre, min_triangles, max_triangles);
  const Sheet sheet = flat_sheet(modes.surface, static_cast<std::size_t>(wanted));
  const Eigen::MatrixXd volume_velocity =
      modes.shapes.at_nodes().cast<double>() * sheet.surface.flux_weights;
  const Vec3 centroid = surface::outer_hull(modes.surface).centroid;

  ModalPressure result;
  result.pressure = Eigen::MatrixXcd::Zero(static_cast<Eigen::Index>(listeners.size()),
                                           static_cast<Eigen::Index>(modes.size()));
  for (std::size_t row = 0; row < listeners.size(); ++row) {
    const Vec3& position = listeners[row].position;
    const int side = heard_side(sheet, position, row);
    const double flight = (position - centroid).norm();
    result.delays.push_back(flight / modal::speed_of_sound);
    for (std::size_t t = 0; t < sheet.surface.size(); ++t) {
      if (sheet.side[t] != side) continue;
      const double r = (position - sheet.surface.centres[t]).norm();
      for (std::size_t mode = 0; mode < modes.size(); ++mode) {
        const auto m = static_cast<Eigen::Index>(mode);
        result.pressure(static_cast<Eigen::Index>(row), m) +=
            volume_velocity(m, static_cast<Eigen::Index>(t)) *
            std::polar(modal::air_density / (2 * std::numbers::pi * r), -k[mode] * (r - flight));
      }
    }
  }
  return result;
}

}  // namespace carillon::synth::radiation
