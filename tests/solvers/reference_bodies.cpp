#include "reference_bodies.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "closed_forms.hpp"
#include "family_shapes.hpp"
#include "test_meshes.hpp"

namespace carillon::test {
namespace {

using solvers::mesh::TetMesh;
using Sizes = std::array<double, 3>;
using Cells = std::array<std::array<int, 3>, 3>;

std::function<TetMesh(int, int)> generated(const GeneratedShape& shape, const Sizes& sizes) {
  return [=](int order, int size) {
    // Order 1 wants more elements, and order 4 fewer, for errors that matter.
    const std::array<double, 4> factor = {0.5, 1, 1, 1.4};
    return mesh_of(
               shape, order,
               factor[static_cast<std::size_t>(order - 1)] * sizes[static_cast<std::size_t>(size)])
        .mesh;
  };
}

std::function<TetMesh(int, int)> box(const Vec3& sides, const Cells& cells) {
  return [=](int order, int size) {
    auto count = cells[static_cast<std::size_t>(size)];
    for (auto& n : count) n *= order == 1 ? 2 : 1;
    return box_mesh(sides, count, order);
  };
}

std::function<TetMesh(int, int)> ball(double radius) {
  return [=](int order, int size) {
    const int cells = size + std::array{4, 2, 1, 1}[static_cast<std::size_t>(order - 1)];
    return with_finer_nodes(ball_mesh(radius, cells, order), ball_mesh(radius, cells, order + 1));
  };
}

std::function<TetMesh(int, int)> shell(double outer, double inner) {
  return [=](int order, int size) {
    const int faces = size + std::array{5, 2, 2, 1}[static_cast<std::size_t>(order - 1)];
    return with_finer_nodes(shell_mesh(outer, inner, faces, 1, order),
                            shell_mesh(outer, inner, faces, 1, order + 1));
  };
}

GeneratedShape cylinder(double radius, double length) {
  return shape_of("disc", {{"radius", radius}, {"thickness", length}});
}

}  // namespace

const std::vector<ReferenceBody>& reference_bodies() {
  static const std::vector<ReferenceBody> bodies = {
      {"disc", "disc_steel_R60_h8mm.csv", steel,
       generated(cylinder(0.06, 0.008), {0.04, 0.027, 0.018})},
      {"hollow sphere", "hollow_sphere_alu_R60mm_r50mm.csv", aluminium, shell(0.06, 0.05)},
      {"bar", "rpr_bar_alu_10x15x200mm.csv", aluminium,
       box({0.01, 0.015, 0.2}, {{{1, 1, 10}, {1, 1, 15}, {1, 2, 22}}})},
      {"block", "rpr_block_steel_20x30x50mm.csv", steel,
       box({0.02, 0.03, 0.05}, {{{1, 2, 3}, {2, 3, 5}, {3, 4, 7}}})},
      {"cube", "rpr_cube_steel_50mm.csv", steel,
       box(Vec3::Constant(0.05), {{{2, 2, 2}, {3, 3, 3}, {5, 5, 5}}})},
      {"plate", "rpr_plate_glass_100x100x5mm.csv", glass,
       box({0.1, 0.1, 0.005}, {{{5, 5, 1}, {8, 8, 1}, {12, 12, 1}}})},
      {"cylinder of aluminium",
       "solid_cylinder_alu_D44.2_H64.14mm.csv",
       {2 * 26e9 * (1 + 58.0 / 168), 58.0 / 168, 2713},
       generated(cylinder(0.0221, 0.06414), {0.03, 0.02, 0.014})},
      {"cylinder of steel", "solid_cylinder_steel_R20_L60mm.csv", steel,
       generated(cylinder(0.02, 0.06), {0.028, 0.019, 0.013})},
      {"rod", "rod_alu_R5_L200mm.csv", aluminium,
       generated(cylinder(0.005, 0.2), {0.02, 0.014, 0.01})},
      {"ring", "ring_steel_Ro50_Ri40_h10mm.csv", steel,
       generated(shape_of("ring", {{"radius", 0.05}, {"inner_radius", 0.04}, {"height", 0.01}}),
                 {0.03, 0.02, 0.014})},
      {"tube", "tube_alu_Ro20_Ri17_L100mm.csv", aluminium,
       generated(shape_of("tube", {{"radius", 0.02}, {"wall", 0.003}, {"length", 0.1}}),
                 {0.02, 0.014, 0.01})},
      {"unit sphere", "sphere_poisson025_unit.csv", {2.5, 0.25, 1}, ball(1)},
      {"sphere", "sphere_steel_R50mm.csv", steel, ball(0.05)},
  };
  return bodies;
}

const ReferenceBody& reference_body(const std::string& name) {
  for (const auto& body : reference_bodies()) {
    if (body.name == name) return body;
  }
  throw std::invalid_argument("no body " + name);
}

std::vector<double> table_frequencies(const std::string& table) {
  const auto path = data_folder() + "/reference_modes/" + table;
  const auto frequency = csv_column(path, "f_hz");
  const auto multiplicity = csv_column(path, "multiplicity");
  // Boxes list every mode on its own, and the other tables every frequency once.
  const bool lists_modes = table.starts_with("rpr_");
  std::vector<double> out;
  for (std::size_t k = 0; k < frequency.size(); ++k) {
    if (multiplicity[k] == "cut") continue;
    out.insert(out.end(), lists_modes ? 1 : std::stoul(multiplicity[k]), std::stod(frequency[k]));
  }
  return out;
}

Effectivity measure_effectivity(const solvers::modes::Modes& modes, std::span<const double> truth,
                                std::span<const double> doubts) {
  Effectivity out;
  std::vector<double> ratios;
  for (std::size_t k = 0; k < std::min(modes.size(), truth.size()); ++k) {
    const double off = cents(modes.frequency(k), truth[k]), estimate = modes.pitch_errors[k];
    double smallest = std::abs(off), largest = smallest;
    if (!doubts.empty()) {
      smallest = std::max(0.0, off);
      largest = smallest + doubts[k];
    }
    if (largest <= 0.2) continue;
    ratios.push_back(estimate / largest);
    out.worst_error = std::max(out.worst_error, largest);
    if (estimate >= 0.7 * smallest && estimate <= 2.5 * largest) continue;
    out.complaint += fmt::format(
        "mode {} at {:.2f} Hz: {:.3f} to {:.3f} cents off {:.2f} Hz, estimated {:.3f}\n", k + 1,
        modes.frequency(k), smallest, largest, truth[k], estimate);
  }
  out.compared = ratios.size();
  if (ratios.empty()) return out;
  std::sort(ratios.begin(), ratios.end());
  out.minimum = ratios.front();
  out.median = ratios[ratios.size() / 2];
  out.maximum = ratios.back();
  return out;
}

}  // namespace carillon::test
