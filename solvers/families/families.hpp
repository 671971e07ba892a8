#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "solvers/mesh/meridian.hpp"
#include "solvers/mesh/shape_source.hpp"

namespace carillon::solvers::families {

/// One parameter of a family: name, default range and what it means.
struct FamilyParameter {
  std::string name;
  double low;  ///< default range of a household object, SI
  double high;
  std::string meaning;
  bool may_be_zero = false;  ///< else it is positive
};

/// A family of generated bodies with true wall thickness.
struct Family {
  std::string name;
  std::string description;
  std::vector<FamilyParameter> parameters;
  /// Throws InputError when parameters contradict each other (wall thicker than the radius ...).
  void (*check)(const mesh::GeneratedShape& shape);
  /// Tetrahedra of the body at an order, boundary nodes on the true surface. Null: Gmsh makes them,
  /// see mesh_family().
  mesh::MeshResult (*mesh)(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options);
  /// Section of a body of revolution about z (checks the shape first); null for other bodies.
  mesh::Meridian (*meridian)(const mesh::GeneratedShape& shape) = nullptr;
  /// Size of a body without a section.
  mesh::ShapeExtent (*extent)(const mesh::GeneratedShape& shape) = nullptr;
  /// Cells that one layer needs to follow the family's curves, however large they may be; counted
  /// on meshes of instances in the middle of the ranges.
  double curve_cells = 0;
  /// The preset that such bodies are usually made of, where none is named; "": no usual one.
  std::string usual_material = {};
};

/// All families: bar, block, tile, disc, cylinder, tube, ring, plate (dinner plate), bowl, cup,
/// vase, bell, box, can, bauble, sphere, pebble, torus, cone, wrench, turned.
std::span<const Family> families();
/// @throws InputError  unknown; names the nearest
const Family& find_family(const std::string& name);

/// Size of a shape of any family, from its parameters.
/// @throws InputError  they do not fit together
mesh::ShapeExtent extent_of(const mesh::GeneratedShape& shape);

/// Scales a shape so that the longest side of its box is so long [m].
/// @throws InputError  its parameters do not fit together
void scale_to(mesh::GeneratedShape& shape, double length);

/// What a person should know of a turned profile: one that keeps away from the axis by less than a
/// twentieth of its radius leaves a bore that may be a slip. "" for all others.
std::string bore_warning(const mesh::GeneratedShape& shape);

/// Tetrahedra of a shape of any family; in carillon_mesher.
mesh::MeshResult mesh_family(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options);

/// How a drawing is read as a profile.
struct SvgProfileOptions {
  double height = 0;  ///< of the profile [m]; 0: the drawing's size on paper
  /// left, right (of the outline), or x=NUMBER in its coordinates; "": x=0, which it has to reach
  std::string axis;
  std::string id;  ///< of the outline; "": the only one that encloses an area
};

/// Profile of an SVG drawing (svg_outlines.hpp) as a closed polygon (radius, height): x is the
/// radius, y (which points down in SVG) becomes height, from 0. An outline left of its axis is
/// turned over.
/// @throws InputError  no outline or several, one that lies across the axis or crosses itself, no
///                     size
std::vector<std::array<double, 2>> profile_from_svg(const std::string& path,
                                                    const SvgProfileOptions& options);

}  // namespace carillon::solvers::families
