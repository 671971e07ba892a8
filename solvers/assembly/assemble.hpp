#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/assembly/mirror_class.hpp"
#include "solvers/assembly/partition.hpp"
#include "solvers/elements/elastic.hpp"
#include "solvers/elements/element.hpp"

namespace carillon::solvers::assembly {

/// Units in which the equations are solved: lengths in the body's longest side, moduli in the
/// largest Young's modulus, densities in the largest density. Matrices then have entries near 1,
/// which pivot thresholds and tolerances rely on.
struct Scales {
  double length = 1;           ///< [m]
  double modulus = 1;          ///< [Pa]
  double density = 1;          ///< [kg/m^3]
  Vec3 origin = Vec3::Zero();  ///< middle of the bounding box [m]

  /// lambda [rad^2/s^2] of a dimensionless eigenvalue 1.
  double eigenvalue() const { return modulus / (density * length * length); }
  /// Dimensionless eigenvalue of a frequency [Hz].
  double from_frequency(double hertz) const;
  double to_frequency(double eigenvalue) const;
};
Scales scales_of(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions);

/// One rank's rows of K and M, dimensionless. Three unknowns (x, y, z) to a node; M couples equal
/// components only, the same for all three, so it is kept as one number for each pair of nodes.
struct System {
  Scales scales;
  Partition partition;
  NodeGraph graph;
  std::vector<double> stiffness;  ///< as block CSR rows: row 3 r + i holds 3 x (columns of r)
  std::vector<double> mass;       ///< one for each graph.column
  MirrorClass mirror;             ///< of the fields that count
  /// Of every node by its new number, the components that the class holds at zero (bits); empty
  /// where it holds none. A held unknown is cut off: K keeps its diagonal entry alone, and M has
  /// none there (couples()), though `mass` does. Fields are zero there.
  std::vector<std::uint8_t> held;

  std::int64_t unknowns() const { return 3 * static_cast<std::int64_t>(partition.node_count()); }
  /// Without those that are held.
  std::int64_t free_unknowns() const;
  std::int32_t owned_unknowns() const { return 3 * graph.rows(); }
  bool is_held(std::int32_t number, int component) const {
    return !held.empty() && (held[static_cast<std::size_t>(number)] >> component & 1) != 0;
  }
  /// Whether M couples a component of two nodes, by their new numbers.
  bool couples(std::int32_t one, std::int32_t other, int component) const {
    return !is_held(one, component) && !is_held(other, component);
  }
};

/// Sets what a class holds at zero: owned unknowns x any.
void hold(const System& system, Eigen::Ref<Eigen::MatrixXd> fields);

/// This rank's rows of K and M, all zero.
System empty_system(const mesh::TetMesh& mesh, const Scales& scales, Partition part, MPI_Comm comm);
/// Elements that touch a node of this rank, ascending.
std::vector<std::size_t> elements_of_rank(const mesh::TetMesh& mesh, const System& system);
/// Adds an element's matrices to the rows that this rank owns.
///
/// @param k  3 nodes x 3 nodes
/// @param m  nodes x nodes, one component
void add_element(std::span<const std::int32_t> element, const Eigen::MatrixXd& k,
                 const Eigen::MatrixXd& m, System& system);

/// Each rank computes every element that touches a node it owns and keeps its own rows: no
/// communication, and entries that do not depend on the number of ranks.
///
/// @param part    the mesh cut into as many parts as comm has ranks
/// @param mirror  the class of fields that are wanted, where the mesh is a part beside its planes
/// @throws core::SolverError  an element's Jacobian is not positive; names the element
/// @note Collective on comm.
System assemble(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                Partition part, MPI_Comm comm, const MirrorClass& mirror = {});

/// Dimensionless constants of each region.
std::vector<elements::ElasticConstants> elastic_constants(
    std::span<const elements::Elastic> regions, const Scales& scales);
/// Dimensionless node positions of an element.
void gather(const mesh::TetMesh& mesh, std::size_t element, const Scales& scales,
            elements::Coordinates& nodes);

}  // namespace carillon::solvers::assembly
