#include "solvers/mesh/mirrored_part.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_map>

#include "solvers/elements/lagrange.hpp"
#include "solvers/mesh/raise_order.hpp"

namespace carillon::solvers::mesh {
namespace {

/// Of a body's longest side: how exactly a plane must mirror.
constexpr double exact = 1e-9;

/// Finds nodes by their place.
class Places {
 public:
  Places(const std::vector<Vec3>& points, double tolerance)
      : points_(points), tolerance_(tolerance) {
    for (std::size_t n = 0; n < points.size(); ++n) {
      cells_.emplace(key(cell_of(points[n])), static_cast<std::int32_t>(n));
    }
  }

  /// The node that is nearest to a point, if within the tolerance; else -1.
  std::int32_t at(const Vec3& point) const {
    // A point and a node that is within the tolerance lie in the same cell or in neighbours, and
    // then both at their common side.
    std::int32_t nearest = -1;
    double distance = tolerance_;
    std::array<std::uint64_t, 8> seen{};
    for (std::size_t corner = 0; corner < seen.size(); ++corner) {
      Vec3 moved = point;
      for (std::size_t i = 0; i < 3; ++i) {
        moved[static_cast<Eigen::Index>(i)] += (corner >> i & 1) != 0 ? tolerance_ : -tolerance_;
      }
      const auto cell = seen[corner] = key(cell_of(moved));
      if (std::find(seen.begin(), seen.begin() + static_cast<std::ptrdiff_t>(corner), cell) !=
          seen.begin() + static_cast<std::ptrdiff_t>(corner)) {
        continue;
      }
      const auto [first, last] = cells_.equal_range(cell);
      for (auto it = first; it != last; ++it) {
        const double d = (points_[static_cast<std::size_t>(it->second)] - point).norm();
        if (d > distance) continue;
        distance = d;
        nearest = it->second;
      }
    }
    return nearest;
  }

 private:
  std::array<std::int64_t, 3> cell_of(const Vec3& point) const {
    constexpr double cells_to_tolerance = 1000;
    std::array<std::int64_t, 3> cell;
    for (std::size_t i = 0; i < 3; ++i) {
      cell[i] = static_cast<std::int64_t>(
          std::floor(point[static_cast<Eigen::Index>(i)] / (cells_to_tolerance * tolerance_)));
    }
    return cell;
  }
  static std::uint64_t key(const std::array<std::int64_t, 3>& cell) {
    std::uint64_t hash = 0;
    for (const auto c : cell) {
      hash = (hash ^ static_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 29;
    }
    return hash;
  }

  const std::vector<Vec3>& points_;
  double tolerance_;
  std::unordered_multimap<std::uint64_t, std::int32_t> cells_;
};

/// For each permutation of an element's corners, numbered as std::next_permutation() gives them,
/// where its nodes go.
class CornerPermutations {
 public:
  explicit CornerPermutations(int order) {
    const auto& lattice = elements::tetrahedron_lattice(order);
    std::map<std::array<int, 4>, std::size_t> place;
    for (std::size_t k = 0; k < lattice.size(); ++k) place[lattice[k]] = k;
    std::array<std::size_t, 4> corners = {0, 1, 2, 3};
    do {
      auto& moved = moved_[corners];
      for (const auto& at : lattice) {
        std::array<int, 4> there;
        for (std::size_t i = 0; i < 4; ++i) there[corners[i]] = at[i];
        moved.push_back(place.at(there));
      }
    } while (std::next_permutation(corners.begin(), corners.end()));
  }
  /// @param corners  the image's corner that each corner goes to
  /// @return the image's node that each node goes to
  const std::vector<std::size_t>& at(const std::array<std::size_t, 4>& corners) const {
    return moved_.at(corners);
  }

 private:
  std::map<std::array<std::size_t, 4>, std::vector<std::size_t>> moved_;
};

std::array<std::int32_t, 4> sorted_corners(std::span<const std::int32_t> element) {
  std::array<std::int32_t, 4> corners = {element[0], element[1], element[2], element[3]};
  std::sort(corners.begin(), corners.end());
  return corners;
}

void move_into_planes(std::span<const MirrorPlane> planes, double tolerance,
                      std::vector<Vec3>& points) {
  for (auto& point : points) {
    for (const auto& plane : planes) {
      auto& height = point[plane.axis];
      if (std::abs(height - plane.position) <= tolerance) height = plane.position;
    }
  }
}

/// What of a body lies above planes that cut none of its elements.
struct UpperPart {
  TetMesh mesh;
  std::vector<std::int32_t> elements;  ///< the body's
  std::vector<std::int32_t> number;    ///< in the part, of each of the body's nodes; -1 below
};

/// Nodes of the next order of those elements.
void take_finer_nodes(const TetMesh& mesh, UpperPart& part) {
  if (mesh.finer_nodes.empty()) return;
  const auto whole = numbering_at(mesh, mesh.order + 1).elements;
  const auto own = numbering_at(part.mesh, mesh.order + 1);
  const auto count = static_cast<std::size_t>(elements::nodes_per_tetrahedron(mesh.order + 1));
  part.mesh.finer_nodes.resize(own.first_use.size());
  if (!mesh.finer_gaps.empty()) part.mesh.finer_gaps.resize(own.first_use.size());
  for (std::size_t e = 0; e < part.elements.size(); ++e) {
    const auto from = static_cast<std::size_t>(part.elements[e]) * count;
    for (std::size_t k = 0; k < count; ++k) {
      const auto here = static_cast<std::size_t>(own.elements[e * count + k]);
      const auto there = static_cast<std::size_t>(whole[from + k]);
      part.mesh.finer_nodes[here] = mesh.finer_nodes[there];
      if (!mesh.finer_gaps.empty()) part.mesh.finer_gaps[here] = mesh.finer_gaps[there];
    }
  }
}

/// Its faces are those of the body: none of them lies in a plane that has elements on both sides.
UpperPart upper_part(const TetMesh& mesh, std::span<const MirrorPlane> planes, double tolerance) {
  UpperPart part;
  part.mesh.order = mesh.order;
  part.mesh.region_names = mesh.region_names;
  for (const auto& point : mesh.nodes) {
    const bool above = std::all_of(planes.begin(), planes.end(), [&](const MirrorPlane& plane) {
      return point[plane.axis] >= plane.position - tolerance;
    });
    part.number.push_back(above ? static_cast<std::int32_t>(part.mesh.nodes.size()) : -1);
    if (above) part.mesh.nodes.push_back(point);
  }
  const auto is_above = [&part](std::span<const std::int32_t> nodes) {
    return std::all_of(nodes.begin(), nodes.end(), [&part](std::int32_t n) {
      return part.number[static_cast<std::size_t>(n)] >= 0;
    });
  };
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    if (!is_above(element)) continue;
    part.elements.push_back(static_cast<std::int32_t>(e));
    part.mesh.regions.push_back(mesh.regions[e]);
    for (const auto n : element)
      part.mesh.elements.push_back(part.number[static_cast<std::size_t>(n)]);
  }
  const auto per_face = static_cast<std::size_t>(elements::nodes_per_face(mesh.order));
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = std::span(mesh.faces).subspan(f * per_face, per_face);
    if (!is_above(face)) continue;
    for (const auto n : face) part.mesh.faces.push_back(part.number[static_cast<std::size_t>(n)]);
  }
  take_finer_nodes(mesh, part);
  move_into_planes(planes, tolerance, part.mesh.nodes);
  move_into_planes(planes, tolerance, part.mesh.finer_nodes);
  return part;
}

/// Whether an element has nodes on both sides of a plane.
bool crosses(const TetMesh& mesh, std::size_t element, const MirrorPlane& plane, double tolerance) {
  bool above = false, below = false;
  for (const auto n : mesh.element(element)) {
    const double height = mesh.nodes[static_cast<std::size_t>(n)][plane.axis] - plane.position;
    above = above || height > tolerance;
    below = below || height < -tolerance;
  }
  return above && below;
}

/// A mesh as mirrors see it.
class Mirrors {
 public:
  explicit Mirrors(const TetMesh& mesh)
      : mesh_(mesh),
        box_(bounding_box(mesh.nodes)),
        tolerance_(exact * box_.longest_side()),
        places_(mesh.nodes, tolerance_),
        permuted_(mesh.order),
        permuted_finer_(mesh.order + 1) {}

  const Box& box() const { return box_; }
  double tolerance() const { return tolerance_; }

  /// The image of every node, where the plane that halves the box along an axis is one of symmetry.
  std::optional<std::vector<std::int32_t>> images(const MirrorPlane& plane) {
    std::vector<std::int32_t> image(mesh_.nodes.size(), -1);
    // Most planes of a mesh that has none fail at its first nodes.
    for (std::size_t n = 0; n < image.size(); ++n) {
      image[n] = places_.at(reflect(mesh_.nodes[n], plane));
      if (image[n] < 0) return std::nullopt;
    }
    if (element_of_.empty()) number_elements();
    for (std::size_t e = 0; e < mesh_.element_count(); ++e) {
      if (crosses(mesh_, e, plane, tolerance_) || !maps(e, plane, image)) return std::nullopt;
    }
    return image;
  }

 private:
  void number_elements() {
    for (std::size_t e = 0; e < mesh_.element_count(); ++e)
      element_of_.emplace_back(sorted_corners(mesh_.element(e)), static_cast<std::int32_t>(e));
    std::sort(element_of_.begin(), element_of_.end());
    if (!mesh_.finer_nodes.empty()) finer_ = numbering_at(mesh_, mesh_.order + 1).elements;
  }

  /// Whether an element's image is an element, node by node.
  bool maps(std::size_t e, const MirrorPlane& plane, const std::vector<std::int32_t>& image) const {
    const auto element = mesh_.element(e);
    std::array<std::int32_t, 4> there;
    for (std::size_t i = 0; i < 4; ++i) there[i] = image[static_cast<std::size_t>(element[i])];
    const auto key = sorted_corners(there);
    const auto found = std::lower_bound(
        element_of_.begin(), element_of_.end(), key,
        [](const auto& entry, const auto& corners) { return entry.first < corners; });
    if (found == element_of_.end() || found->first != key) return false;
    const auto other = static_cast<std::size_t>(found->second);
    if (mesh_.regions[e] != mesh_.regions[other]) return false;
    const auto nodes = mesh_.element(other);
    std::array<std::size_t, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) {
      corners[i] = static_cast<std::size_t>(std::find(nodes.begin(), nodes.begin() + 4, there[i]) -
                                            nodes.begin());
    }
    const auto& moved = permuted_.at(corners);
    for (std::size_t k = 0; k < element.size(); ++k) {
      if (nodes[moved[k]] != image[static_cast<std::size_t>(element[k])]) return false;
    }
    return finer_.empty() || maps_finer(e, other, permuted_finer_.at(corners), plane);
  }

  bool maps_finer(std::size_t e, std::size_t other, const std::vector<std::size_t>& moved,
                  const MirrorPlane& plane) const {
    const auto count = moved.size();
    const auto at = [&](std::size_t element, std::size_t k) {
      return static_cast<std::size_t>(finer_[element * count + k]);
    };
    const MirrorPlane through_zero{plane.axis, 0};
    for (std::size_t k = 0; k < count; ++k) {
      const auto here = at(e, k), there = at(other, moved[k]);
      if (!near(reflect(mesh_.finer_nodes[here], plane), mesh_.finer_nodes[there])) return false;
      if (!mesh_.finer_gaps.empty() &&
          !near(reflect(mesh_.finer_gaps[here], through_zero), mesh_.finer_gaps[there])) {
        return false;
      }
    }
    return true;
  }

  bool near(const Vec3& a, const Vec3& b) const { return (a - b).norm() <= tolerance_; }

  const TetMesh& mesh_;
  Box box_;
  double tolerance_;
  Places places_;
  CornerPermutations permuted_, permuted_finer_;
  std::vector<std::pair<std::array<std::int32_t, 4>, std::int32_t>> element_of_;  ///< by corners
  std::vector<std::int32_t> finer_;  ///< elements x nodes of the next order
};

}  // namespace

Vec3 reflect(const Vec3& point, const MirrorPlane& plane) {
  Vec3 out = point;
  out[plane.axis] = 2 * plane.position - point[plane.axis];
  return out;
}

std::optional<MirroredPart> mirrored_part(const TetMesh& mesh, std::span<const int> planes_wanted) {
  Mirrors mirrors(mesh);
  MirroredPart part;
  part.box = mirrors.box();
  const Vec3 middle = (part.box.low + part.box.high) / 2;
  std::vector<std::vector<std::int32_t>> image;  // in each plane
  for (const int axis : planes_wanted) {
    const MirrorPlane plane{axis, middle[axis]};
    auto images = mirrors.images(plane);
    if (!images) continue;
    part.planes.push_back(plane);
    image.push_back(std::move(*images));
  }
  if (part.planes.empty()) return std::nullopt;

  auto upper = upper_part(mesh, part.planes, mirrors.tolerance());
  part.images.assign(mesh.nodes.size(), 0);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    auto at = static_cast<std::int32_t>(n);
    for (std::size_t p = 0; p < part.planes.size(); ++p) {
      const auto& plane = part.planes[p];
      if (mesh.nodes[n][plane.axis] >= plane.position - mirrors.tolerance()) continue;
      at = image[p][static_cast<std::size_t>(at)];
      part.images[n] = static_cast<std::uint8_t>(part.images[n] | 1u << p);
    }
    part.nodes.push_back(upper.number[static_cast<std::size_t>(at)]);
  }
  part.mesh = std::move(upper.mesh);
  part.elements = std::move(upper.elements);
  return part;
}

namespace {

/// Joins a mesh to its image.
TetMesh with_image(const TetMesh& part, const MirrorPlane& plane, double tolerance) {
  // Corners 0 and 1 change places, so that the image is not inside out.
  const CornerPermutations permutations(part.order), finer_permutations(part.order + 1);
  constexpr std::array<std::size_t, 4> exchanged = {1, 0, 2, 3};
  const auto is_shared = [&](const Vec3& point) {
    return std::abs(point[plane.axis] - plane.position) <= tolerance;
  };
  TetMesh out = part;
  out.finer_nodes.clear();
  out.finer_gaps.clear();
  move_into_planes({&plane, 1}, tolerance, out.nodes);
  std::vector<std::int32_t> image(part.nodes.size());
  for (std::size_t n = 0; n < part.nodes.size(); ++n) {
    image[n] = static_cast<std::int32_t>(is_shared(part.nodes[n]) ? n : out.nodes.size());
    if (!is_shared(part.nodes[n])) out.nodes.push_back(reflect(part.nodes[n], plane));
  }
  const auto& moved = permutations.at(exchanged);
  for (std::size_t e = 0; e < part.element_count(); ++e) {
    const auto element = part.element(e);
    // The permutation is its own inverse.
    for (const auto k : moved) out.elements.push_back(image[static_cast<std::size_t>(element[k])]);
    out.regions.push_back(part.regions[e]);
  }
  out.faces = boundary_faces(out);
  if (part.finer_nodes.empty()) return out;

  const auto before = numbering_at(part, part.order + 1).elements;
  const auto after = numbering_at(out, part.order + 1);
  const auto& finer_moved = finer_permutations.at(exchanged);
  const auto count = finer_moved.size();
  const MirrorPlane through_zero{plane.axis, 0};
  out.finer_nodes.resize(after.first_use.size());
  if (!part.finer_gaps.empty()) out.finer_gaps.resize(after.first_use.size());
  for (std::size_t e = 0; e < part.element_count(); ++e) {
    for (std::size_t k = 0; k < count; ++k) {
      const auto from = static_cast<std::size_t>(before[e * count + k]);
      const auto own = static_cast<std::size_t>(after.elements[e * count + k]);
      const auto other = static_cast<std::size_t>(
          after.elements[(part.element_count() + e) * count + finer_moved[k]]);
      // What lies in the plane is written twice, the part's own last.
      out.finer_nodes[other] = reflect(part.finer_nodes[from], plane);
      out.finer_nodes[own] = part.finer_nodes[from];
      if (part.finer_gaps.empty()) continue;
      out.finer_gaps[other] = reflect(part.finer_gaps[from], through_zero);
      out.finer_gaps[own] = part.finer_gaps[from];
    }
  }
  move_into_planes({&plane, 1}, tolerance, out.finer_nodes);
  return out;
}

}  // namespace

TetMesh unfold(const TetMesh& part, std::span<const MirrorPlane> planes) {
  const double tolerance = exact * bounding_box(part.nodes).longest_side();
  TetMesh out = part;
  for (const auto& plane : planes) out = with_image(out, plane, tolerance);
  return out;
}

TetMesh symmetrised(const TetMesh& mesh) {
  const Box box = bounding_box(mesh.nodes);
  const double tolerance = exact * box.longest_side();
  std::vector<MirrorPlane> planes;
  for (int axis = 0; axis < 3; ++axis) {
    const MirrorPlane plane{axis, (box.low[axis] + box.high[axis]) / 2};
    bool cut = false;
    for (std::size_t e = 0; e < mesh.element_count() && !cut; ++e)
      cut = crosses(mesh, e, plane, tolerance);
    if (!cut) planes.push_back(plane);
  }
  if (planes.empty()) return mesh;
  return unfold(upper_part(mesh, planes, tolerance).mesh, planes);
}

}  // namespace carillon::solvers::mesh
