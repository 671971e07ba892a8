#pragma once

#include <array>
#include <cmath>
#include <map>
#include <string>

#include "solvers/families/families.hpp"

namespace carillon::test {

using solvers::families::Family;
using solvers::families::find_family;
using solvers::mesh::GeneratedShape;
using solvers::mesh::MeshOptions;
using solvers::mesh::MeshResult;

/// A shape with every parameter at a fraction of its range.
inline GeneratedShape shape_at(const Family& family, double fraction = 0.5) {
  GeneratedShape shape;
  shape.family = family.name;
  for (const auto& p : family.parameters)
    shape.parameters[p.name] = p.low + fraction * (p.high - p.low);
  if (family.name == "turned")  // a thin goblet: foot, stem and bowl
    shape.profile = {{0, 0},       {0.03, 0},     {0.03, 0.004},  {0.006, 0.012},  {0.006, 0.06},
                     {0.03, 0.09}, {0.034, 0.13}, {0.0315, 0.13}, {0.0275, 0.092}, {0, 0.07}};
  return shape;
}

inline GeneratedShape shape_of(const std::string& family,
                               std::map<std::string, double> parameters) {
  return {family, std::move(parameters), {}};
}

inline MeshResult mesh_of(const GeneratedShape& shape, int order, double element_size = 0) {
  MeshOptions options;
  options.order = order;
  options.element_size = element_size;
  return solvers::families::mesh_family(shape, options);
}

/// Errors of volume with cells of a size and of half of it.
inline std::array<double, 2> volume_errors(const GeneratedShape& shape, int order, double size,
                                           double exact) {
  std::array<double, 2> errors{};
  for (std::size_t i = 0; i < 2; ++i)
    errors[i] = std::abs(
        mesh_of(shape, order, size / std::pow(2, static_cast<double>(i))).quality.volume / exact -
        1);
  return errors;
}

}  // namespace carillon::test
