#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "solvers/assembly/assemble.hpp"
#include "solvers/elements/element.hpp"
#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::eigen {

/// Displacement fields on a mesh, dimensionless: fields x 3 nodes, unknowns node by node (x, y, z).
/// The values of all fields at a node lie together, so an element's part is a few copies away from
/// a dense product.
using Fields = Eigen::MatrixXd;

/// Fields at the nodes of one element: fields x 3 nodes.
void gather(const Fields& fields, std::span<const std::int32_t> element, Fields& local);
void scatter_add(const Fields& local, std::span<const std::int32_t> element, Fields& fields);
/// The same numbers with a node to a column: 3 fields x nodes. What acts on the three components
/// alike, nodes x nodes, is multiplied from the right.
Eigen::Map<Eigen::MatrixXd> by_node(Fields& local);
Eigen::Map<const Eigen::MatrixXd> by_node(const Fields& local);
/// The rows of `fields` that this rank owns: owned unknowns x fields.
Eigen::MatrixXd owned_rows(const assembly::System& system, const Fields& fields);
/// Adds rows that this rank owns, owned unknowns x fields, to `fields`.
void add_owned(const assembly::System& system, const Eigen::Ref<const Eigen::MatrixXd>& owned,
               Fields& fields);
/// Adds up the ranks' parts, of fields or of forms on them. Collective.
void sum_over_ranks(Fields& fields, MPI_Comm comm);

/// The elements of a body at the next order (next_order), and A = K - sigma M and M on them: what
/// the solved order is measured against. Operators work element by element on all fields at once;
/// each rank computes its own elements, and every rank holds whole fields. On a part beside mirror
/// planes fields are those of the system's class, as are their products.
class FinerSpace {
 public:
  /// @param mesh    the mesh that `system` was assembled from
  /// @param shift   sigma < 0, dimensionless
  /// @param memory  [byte] that this rank's element matrices may take; where they would take more
  ///                they are computed at every use
  /// @note Collective.
  FinerSpace(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
             const assembly::System& system, double shift, std::int64_t memory, MPI_Comm comm);

  /// The elements at the next order. Those that nodes on the true surface would turn inside out
  /// keep the curve that they have.
  const mesh::TetMesh& mesh() const { return mesh_; }
  /// Whether nodes lie off where they should be (TetMesh::finer_gaps, and those kept back here).
  bool has_gaps() const { return !gaps_.empty(); }
  /// Sets what the system's class holds at zero.
  void hold(Fields& fields) const;
  /// False where an element is turned inside out all the same: nothing can be measured then.
  bool is_sound() const { return sound_; }
  std::span<const std::size_t> own_elements() const { return own_; }

  /// Calls `use` with the matrix A of this rank's elements and of those that share a corner with
  /// them, ascending.
  void for_each_matrix(
      const std::function<void(std::size_t element, const Eigen::MatrixXd& a)>& use) const;

  /// A x and M x. Rigid motions of each element are left out of K x, where they would cancel only
  /// in exact arithmetic: on thin bodies their rounding outweighs the energy of bending.
  /// @note Collective.
  void forces(const Fields& x, Fields& stiff, Fields& inert) const;
  /// First derivatives of x^T A x and x^T M x, fields x fields, when nodes move to where they
  /// should be and the fields along: what the gaps do to eigenvalues.
  /// @note Collective.
  void close_gaps(const Fields& x, Eigen::MatrixXd& stiff, Eigen::MatrixXd& inert) const;
  /// A x.
  /// @note Collective.
  void apply(const Fields& x, Fields& out) const;
  /// Sums over elements of weight x^T A x, one for each field.
  /// @param weights  of all elements
  /// @note Collective.
  Eigen::ArrayXd weighted_energy(const Fields& x, std::span<const double> weights) const;
  /// M x.
  /// @note Collective.
  void apply_mass(const Fields& x, Fields& out) const;

 private:
  /// Matrices of an element: A, 3 nodes x 3 nodes, and M of one component, nodes x nodes.
  struct Matrices {
    Eigen::MatrixXd a, mass;
  };
  /// Computes the matrices of own elements.
  /// @return elements, of all ranks, that are turned inside out
  std::vector<std::size_t> compute_own();
  bool compute(elements::ElementKernel& kernel, std::size_t element, Matrices& out) const {
    return compute(kernel, element, 0, out);
  }
  /// @param closed  part of the gaps by which nodes are moved
  bool compute(elements::ElementKernel& kernel, std::size_t element, double closed,
               Matrices& out) const;
  const Matrices& matrices(elements::ElementKernel& kernel, std::size_t own,
                           Matrices& scratch) const;
  /// Sum over own elements of multiply(fields of an element, its matrices), over all ranks.
  template <typename Product>
  void sum_elements(const Fields& x, const Product& multiply, Fields& out) const;

  MPI_Comm comm_;
  assembly::Scales scales_;
  mesh::TetMesh mesh_;
  std::vector<Eigen::Index> held_;  ///< columns of Fields that the class holds at zero
  std::vector<Vec3> gaps_;          ///< from each node to where it should be [m]; empty: all zero
  std::vector<elements::ElasticConstants> materials_;
  double mass_factor_;  ///< -sigma
  bool keeps_;          ///< matrices of own elements are kept
  bool sound_ = false;
  std::vector<std::size_t> own_;
  std::vector<Matrices> matrices_;
};

}  // namespace carillon::solvers::eigen
