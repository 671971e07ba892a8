#include "solvers/mesh/tetrahedra/detail/mend_slivers.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "solvers/mesh/outward_faces.hpp"

namespace carillon::solvers::mesh::tetrahedra {
namespace {

using Corners = std::array<std::int32_t, 4>;
using Elements = std::set<std::size_t>;

/// Elements below this sine of a dihedral angle are to go, and what comes must be better by a
/// factor.
const double flat_sine = std::sin(8 * std::numbers::pi / 180);
constexpr double gain = 1.3;

/// Smallest sine of the dihedral angles; negative when the element is inside out.
double worst_sine(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const std::array<const Vec3*, 4> at{&a, &b, &c, &d};
  // Twice the area of the face opposite to each corner.
  const std::array<double, 4> area{(c - b).cross(d - b).norm(), (c - a).cross(d - a).norm(),
                                   (b - a).cross(d - a).norm(), (b - a).cross(c - a).norm()};
  const double six = six_volumes(a, b, c, d);
  double worst = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      // The faces opposite to i and j meet in the edge between the other two corners.
      const std::size_t k = i == 0 ? (j == 1 ? 2 : 1) : 0, l = 6 - i - j - k;
      const double areas = area[i] * area[j];
      worst = std::min(worst, areas > 0 ? six * (*at[k] - *at[l]).norm() / areas : 0);
    }
  return worst;
}

/// A hole in the mesh and the point that fills it.
struct Star {
  Elements removed;
  std::vector<std::array<std::int32_t, 3>> faces;  ///< of the hole, seen from outside
  Vec3 centre = Vec3::Constant(0);
  double worst = -1;  ///< sine
};

class Mender {
 public:
  explicit Mender(TetMesh& mesh) : mesh_(mesh), around_(mesh.nodes.size()) {
    for (std::size_t e = 0; e < mesh.element_count(); ++e) {
      Corners corners;
      std::copy_n(mesh.element(e).begin(), 4, corners.begin());
      add(corners, mesh.regions[e]);
    }
  }

  void run() {
    constexpr int rounds = 3;
    const std::size_t given = elements_.size();
    for (int round = 0; round < rounds; ++round) {
      std::vector<std::pair<double, std::size_t>> flat;
      for (std::size_t e = 0; e < elements_.size(); ++e)
        if (alive_[e] && worst_[e] < flat_sine) flat.emplace_back(worst_[e], e);
      std::sort(flat.begin(), flat.end());
      bool changed = false;
      for (const auto& [worst, e] : flat)
        if (alive_[e] && mend(e)) changed = true;
      if (!changed) break;
    }
    if (elements_.size() > given) write_back();
  }

 private:
  const Vec3& at(std::int32_t n) const { return mesh_.nodes[static_cast<std::size_t>(n)]; }

  void add(const Corners& corners, std::int32_t region) {
    for (const std::int32_t n : corners)
      around_[static_cast<std::size_t>(n)].insert(elements_.size());
    elements_.push_back(corners);
    regions_.push_back(region);
    alive_.push_back(true);
    worst_.push_back(worst_sine(at(corners[0]), at(corners[1]), at(corners[2]), at(corners[3])));
  }

  void remove(std::size_t e) {
    for (const std::int32_t n : elements_[e]) around_[static_cast<std::size_t>(n)].erase(e);
    alive_[e] = false;
  }

  /// Elements that hold two nodes.
  Elements ring(std::int32_t a, std::int32_t b) const {
    Elements both;
    const Elements& first = around_[static_cast<std::size_t>(a)];
    const Elements& second = around_[static_cast<std::size_t>(b)];
    std::set_intersection(first.begin(), first.end(), second.begin(), second.end(),
                          std::inserter(both, both.end()));
    return both;
  }

  /// Holes worth a try: around each edge, around two opposite ones, around all.
  std::vector<Elements> holes(std::size_t e) const {
    const Corners& c = elements_[e];
    std::vector<Elements> holes;
    Elements all;
    const auto join = [](Elements a, const Elements& b) {
      a.insert(b.begin(), b.end());
      return a;
    };
    constexpr std::array<std::array<std::size_t, 4>, 3> pairs{
        {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}}};
    for (const auto& p : pairs) {
      const Elements first = ring(c[p[0]], c[p[1]]), second = ring(c[p[2]], c[p[3]]);
      holes.push_back(first);
      holes.push_back(second);
      holes.push_back(join(first, second));
      all = join(join(std::move(all), first), second);
    }
    holes.push_back(std::move(all));
    return holes;
  }

  bool mend(std::size_t e) {
    Star best;
    for (Elements& hole : holes(e)) {
      Star star = filled(std::move(hole));
      if (star.worst > best.worst) best = std::move(star);
    }
    if (!(best.worst > gain * worst_[e])) return false;
    const auto centre = static_cast<std::int32_t>(mesh_.nodes.size());
    const std::int32_t region = regions_[e];
    mesh_.nodes.push_back(best.centre);
    around_.emplace_back();
    for (const std::size_t gone : best.removed) remove(gone);
    for (const auto& f : best.faces) add({f[0], f[2], f[1], centre}, region);
    return true;
  }

  /// The hole's star about the point where its worst element is best; a worst of -1 when the hole
  /// has none.
  Star filled(Elements hole) const {
    Star star;
    star.removed = std::move(hole);
    const std::int32_t region = regions_[*star.removed.begin()];
    std::set<std::int32_t> corners;
    double volume = 0, longest = 0;
    for (const std::size_t e : star.removed) {
      if (regions_[e] != region) return star;
      const Corners& c = elements_[e];
      volume += six_volumes(at(c[0]), at(c[1]), at(c[2]), at(c[3]));
      corners.insert(c.begin(), c.end());
      for (const auto& f : outward_faces) {
        const std::array<std::int32_t, 3> face{c[f[0]], c[f[1]], c[f[2]]};
        if (!in_hole(face, star.removed, e)) star.faces.push_back(face);
      }
    }
    Vec3 centre = Vec3::Zero();
    for (const std::int32_t n : corners) centre += at(n) / static_cast<double>(corners.size());
    for (const std::int32_t n : corners) longest = std::max(longest, (at(n) - centre).norm());
    const auto worst_at = [&](const Vec3& p) {
      double worst = std::numeric_limits<double>::infinity();
      for (const auto& f : star.faces)
        worst = std::min(worst, worst_sine(at(f[0]), at(f[2]), at(f[1]), p));
      return worst;
    };
    // A search by steps that halve: the worst sine has kinks.
    double worst = worst_at(centre);
    for (double step = 0.3 * longest; step > 0.01 * longest;) {
      Vec3 next = centre;
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        for (const double way : {-step, step}) {
          Vec3 p = centre;
          p[axis] += way;
          const double there = worst_at(p);
          if (there <= worst) continue;
          worst = there;
          next = p;
        }
      if (next == centre) step /= 2;
      centre = next;
    }
    // The star fills the hole when nothing of it is inside out.
    double filled = 0;
    for (const auto& f : star.faces) filled += six_volumes(at(f[0]), at(f[2]), at(f[1]), centre);
    if (worst <= 0 || std::abs(filled - volume) > 1e-9 * volume) return star;
    star.centre = centre;
    star.worst = worst;
    return star;
  }

  /// Whether another element of the hole has the face too.
  bool in_hole(const std::array<std::int32_t, 3>& face, const Elements& hole,
               std::size_t own) const {
    for (const std::size_t e : ring(face[0], face[1]))
      if (e != own && hole.contains(e) &&
          std::find(elements_[e].begin(), elements_[e].end(), face[2]) != elements_[e].end())
        return true;
    return false;
  }

  void write_back() {
    mesh_.elements.clear();
    mesh_.regions.clear();
    for (std::size_t e = 0; e < elements_.size(); ++e) {
      if (!alive_[e]) continue;
      mesh_.elements.insert(mesh_.elements.end(), elements_[e].begin(), elements_[e].end());
      mesh_.regions.push_back(regions_[e]);
    }
    drop_unused_nodes(mesh_);
    mesh_.faces = boundary_faces(mesh_);
  }

  TetMesh& mesh_;
  std::vector<Elements> around_;  ///< of each node
  std::vector<Corners> elements_;
  std::vector<std::int32_t> regions_;
  std::vector<bool> alive_;
  std::vector<double> worst_;
};

}  // namespace

void mend_slivers(TetMesh& mesh) {
  Mender(mesh).run();
}

}  // namespace carillon::solvers::mesh::tetrahedra
