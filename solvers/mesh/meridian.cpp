#include "solvers/mesh/meridian.hpp"

#include <fmt/core.h>

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "core/disjoint_sets.hpp"
#include "core/error.hpp"
#include "solvers/elements/lobatto.hpp"

namespace carillon::solvers::mesh {
namespace {

constexpr std::size_t max_nodes = 200000;

using Edge = std::pair<int, int>;  ///< corner numbers, lower first

Edge edge_of(const MeridianBlock& block, std::size_t side) {
  const int a = block.corners[side], b = block.corners[(side + 1) % 4];
  return {std::min(a, b), std::max(a, b)};
}

/// Length of a side, by chords.
double side_length(const MeridianBlock& block, std::size_t side) {
  constexpr int steps = 16;
  constexpr double u[] = {0, 1, 1, 0, 0}, v[] = {0, 0, 1, 1, 0};
  double length = 0;
  Vec2 before = block.point(u[side], v[side]);
  for (int i = 1; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const Vec2 now =
        block.point((1 - t) * u[side] + t * u[side + 1], (1 - t) * v[side] + t * v[side + 1]);
    length += (now - before).norm();
    before = now;
  }
  return length;
}

/// Numbers of cells along edges: opposite sides of a block have as many, so do all that hang
/// together through blocks.
class Divisions {
 public:
  Divisions(const Meridian& meridian, double cell) {
    for (const auto& block : meridian.blocks) {
      for (std::size_t side = 0; side < 4; ++side) number_of(edge_of(block, side));
    }
    alike_ = core::DisjointSets(edges_.size());
    cells_.assign(edges_.size(), 1);
    for (const auto& block : meridian.blocks) {
      for (std::size_t side = 0; side < 2; ++side) {
        alike_.join(number_of(edge_of(block, side)), number_of(edge_of(block, side + 2)));
      }
    }
    for (const auto& block : meridian.blocks) {
      for (std::size_t side = 0; side < 4; ++side) {
        auto& cells = cells_[alike_.find(number_of(edge_of(block, side)))];
        const double wanted = side_length(block, side) / cell * (1 - 1e-9);
        cells = std::max(cells, std::ceil(std::min(wanted, 1e6)));
      }
    }
  }

  int of(const MeridianBlock& block, std::size_t side) {
    return static_cast<int>(cells_[alike_.find(number_of(edge_of(block, side)))]);
  }

 private:
  std::size_t number_of(const Edge& edge) {
    return edges_.try_emplace(edge, edges_.size()).first->second;
  }

  std::map<Edge, std::size_t> edges_;
  core::DisjointSets alike_;
  std::vector<double> cells_;
};

/// Numbers the nodes of block after block; those on shared edges and corners once.
class Builder {
 public:
  Builder(const Meridian& meridian, int order, double cell)
      : meridian_(meridian), divisions_(meridian, cell) {
    mesh_.order = order;
    for (const auto& block : meridian.blocks) {
      for (std::size_t side = 0; side < 4; ++side) ++uses_[edge_of(block, side)];
    }
  }

  MeridianMesh build() {
    for (const auto& block : meridian_.blocks) add(block);
    return std::move(mesh_);
  }

 private:
  /// Points of a block: `across` x `up` cells of the mesh's order.
  struct Lattice {
    int across, up, order;
    std::vector<std::int32_t> node;

    int width() const { return across * order + 1; }
    int height() const { return up * order + 1; }
    std::int32_t& at(int i, int j) {
      return node[static_cast<std::size_t>(j) * static_cast<std::size_t>(width()) +
                  static_cast<std::size_t>(i)];
    }
  };

  static double parameter(int i, int order, int cells) {
    const int cell = std::min(i / order, cells - 1);
    return (cell + elements::lobatto_nodes(order)[i - cell * order]) / cells;
  }

  [[noreturn]] static void refuse_size() {
    throw core::LimitError(fmt::format("the section needs more than {} nodes", max_nodes),
                           "ask for a lower max_frequency, fewer modes, or a larger element size");
  }

  std::int32_t new_node(Vec2 at) {
    // The formulas of blocks on the axis give a radius within rounding of zero.
    if (std::abs(at.x()) < 1e-14 * (1 + std::abs(at.y()))) at.x() = 0;
    if (mesh_.nodes.size() >= max_nodes) refuse_size();
    mesh_.nodes.push_back(at);
    return static_cast<std::int32_t>(mesh_.nodes.size() - 1);
  }

  std::int32_t corner_node(int corner, const Vec2& at) {
    const auto known = corner_nodes_.find(corner);
    if (known != corner_nodes_.end()) return known->second;
    return corner_nodes_[corner] = new_node(at);
  }

  /// @param k  0 to count, from corner a to corner b
  std::int32_t edge_node(int a, int b, int k, int count, const Vec2& at) {
    if (k == 0) return corner_node(a, at);
    if (k == count) return corner_node(b, at);
    const int from_lower = a < b ? k : count - k;
    const std::pair<Edge, int> key{{std::min(a, b), std::max(a, b)}, from_lower};
    const auto known = edge_nodes_.find(key);
    if (known != edge_nodes_.end()) return known->second;
    return edge_nodes_[key] = new_node(at);
  }

  /// Counter-clockwise, or turned over by exchanging u and v.
  static MeridianBlock upright(const MeridianBlock& block) {
    constexpr double h = 1e-4;
    const Vec2 du = block.point(0.5 + h, 0.5) - block.point(0.5 - h, 0.5);
    const Vec2 dv = block.point(0.5, 0.5 + h) - block.point(0.5, 0.5 - h);
    if (du.x() * dv.y() - du.y() * dv.x() > 0) return block;
    const auto& c = block.corners;
    const auto point = block.point;
    return {{c[0], c[3], c[2], c[1]}, [point](double u, double v) { return point(v, u); }};
  }

  void add(const MeridianBlock& any) {
    const MeridianBlock block = upright(any);
    const int p = mesh_.order;
    Lattice lattice{divisions_.of(block, 0), divisions_.of(block, 1), p, {}};
    const int w = lattice.width(), h = lattice.height();
    if (static_cast<double>(w) * h > max_nodes) refuse_size();
    lattice.node.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
    const auto& c = block.corners;
    for (int j = 0; j < h; ++j) {
      for (int i = 0; i < w; ++i) {
        const Vec2 at = block.point(parameter(i, p, lattice.across), parameter(j, p, lattice.up));
        lattice.at(i, j) = j == 0       ? edge_node(c[0], c[1], i, w - 1, at)
                           : j == h - 1 ? edge_node(c[3], c[2], i, w - 1, at)
                           : i == 0     ? edge_node(c[0], c[3], j, h - 1, at)
                           : i == w - 1 ? edge_node(c[1], c[2], j, h - 1, at)
                                        : new_node(at);
      }
    }
    for (int b = 0; b < lattice.up; ++b) {
      for (int a = 0; a < lattice.across; ++a) {
        for (int j = 0; j <= p; ++j) {
          for (int i = 0; i <= p; ++i) mesh_.elements.push_back(lattice.at(a * p + i, b * p + j));
        }
      }
    }
    add_boundary(block, lattice);
  }

  void add_boundary(const MeridianBlock& block, Lattice& lattice) {
    const int p = lattice.order, w = lattice.width() - 1, h = lattice.height() - 1;
    for (std::size_t side = 0; side < 4; ++side) {
      if (uses_.at(edge_of(block, side)) > 1) continue;
      const int steps = side % 2 == 0 ? w : h;
      const auto node = [&](int k) {
        switch (side) {
          case 0:
            return lattice.at(k, 0);
          case 1:
            return lattice.at(w, k);
          case 2:
            return lattice.at(w - k, h);
          default:
            return lattice.at(0, h - k);
        }
      };
      for (int first = 0; first < steps; first += p) {
        bool on_axis = true;
        for (int k = 0; k <= p; ++k) {
          on_axis = on_axis && mesh_.nodes[static_cast<std::size_t>(node(first + k))].x() == 0;
        }
        if (on_axis) continue;
        for (int k = 0; k <= p; ++k) mesh_.boundary.push_back(node(first + k));
      }
    }
  }

  const Meridian& meridian_;
  Divisions divisions_;
  MeridianMesh mesh_;
  std::map<Edge, int> uses_;
  std::map<int, std::int32_t> corner_nodes_;
  std::map<std::pair<Edge, int>, std::int32_t> edge_nodes_;
};

/// Points between four straight sides.
std::function<Vec2(double, double)> bilinear(const Vec2& a, const Vec2& b, const Vec2& c,
                                             const Vec2& d) {
  return [=](double u, double v) -> Vec2 {
    return (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * d + u * c);
  };
}

}  // namespace

Meridian rectangular_meridian(const std::vector<double>& radii,
                              const std::vector<double>& heights) {
  Meridian out;
  const int width = static_cast<int>(radii.size());
  for (std::size_t j = 0; j + 1 < heights.size(); ++j) {
    for (std::size_t i = 0; i + 1 < radii.size(); ++i) {
      const int corner = static_cast<int>(j) * width + static_cast<int>(i);
      const double r0 = radii[i], r1 = radii[i + 1], z0 = heights[j], z1 = heights[j + 1];
      out.blocks.push_back({{corner, corner + 1, corner + width + 1, corner + width},
                            bilinear({r0, z0}, {r1, z0}, {r1, z1}, {r0, z1})});
    }
  }
  return out;
}

std::vector<double> with_edge_layers(double length, double wall) {
  const double layer = 1.5 * wall;
  if (length < 4 * layer) return {0, length};
  return {0, layer, length - layer, length};
}

Meridian ball_meridian(double radius) {
  // Two squares in the middle, and around them four blocks that blend their sides to the circle.
  const double a = 0.5 * radius;
  enum Corner { south, equator_in, north, se, ne, bottom, right, top, se_out, ne_out };
  const Vec2 at_se(a, -a), at_ne(a, a);
  const double quarter = std::numbers::pi / 4;
  const auto shell = [radius](const Vec2& from, const Vec2& to, double first, double last) {
    return [=](double u, double v) -> Vec2 {
      const double angle = (1 - u) * first + u * last;
      const Vec2 inner = (1 - u) * from + u * to;
      const Vec2 outer(radius * std::cos(angle), radius * std::sin(angle));
      return (1 - v) * inner + v * outer;
    };
  };
  constexpr int middle = 10;
  return {{{{south, se, middle, equator_in}, bilinear({0, -a}, at_se, {a, 0}, {0, 0})},
           {{equator_in, middle, ne, north}, bilinear({0, 0}, {a, 0}, at_ne, {0, a})},
           {{south, se, se_out, bottom}, shell({0, -a}, at_se, -2 * quarter, -quarter)},
           {{se, middle, right, se_out}, shell(at_se, {a, 0}, -quarter, 0)},
           {{middle, ne, ne_out, right}, shell({a, 0}, at_ne, 0, quarter)},
           {{ne, north, top, ne_out}, shell(at_ne, {0, a}, quarter, 2 * quarter)}}};
}

void grade_towards(Meridian& meridian, int corner, int steps, double ratio) {
  int next = 0;
  for (const auto& block : meridian.blocks) {
    for (const int c : block.corners) next = std::max(next, c + 1);
  }
  for (int step = 0; step < steps; ++step) {
    Meridian finer;
    std::map<int, int> split;  ///< far corner of an edge at `corner` -> corner where it is cut
    const auto cut = [&](int far) {
      const auto [entry, is_new] = split.try_emplace(far, next);
      if (is_new) ++next;
      return entry->second;
    };
    for (const auto& block : meridian.blocks) {
      const auto found = std::find(block.corners.begin(), block.corners.end(), corner);
      if (found == block.corners.end()) {
        finer.blocks.push_back(block);
        continue;
      }
      // Turned so that the corner is at (0, 0).
      const auto turn = static_cast<std::size_t>(found - block.corners.begin());
      const auto point = block.point;
      const auto turned = [point, turn](double u, double v) -> Vec2 {
        switch (turn) {
          case 0:
            return point(u, v);
          case 1:
            return point(1 - v, u);
          case 2:
            return point(1 - u, 1 - v);
          default:
            return point(v, 1 - u);
        }
      };
      const int right = block.corners[(turn + 1) % 4], far = block.corners[(turn + 2) % 4],
                up = block.corners[(turn + 3) % 4];
      const int on_right = cut(right), on_up = cut(up), inside = next++;
      const auto piece = [&turned](std::array<int, 4> corners, const Vec2& a, const Vec2& b,
                                   const Vec2& c, const Vec2& d) -> MeridianBlock {
        const auto local = bilinear(a, b, c, d);
        return {corners, [turned, local](double u, double v) -> Vec2 {
                  const Vec2 x = local(u, v);
                  return turned(x.x(), x.y());
                }};
      };
      const double q = ratio;
      finer.blocks.push_back(
          piece({corner, on_right, inside, on_up}, {0, 0}, {q, 0}, {q, q}, {0, q}));
      finer.blocks.push_back(piece({on_right, right, far, inside}, {q, 0}, {1, 0}, {1, 1}, {q, q}));
      finer.blocks.push_back(piece({on_up, inside, far, up}, {0, q}, {q, q}, {1, 1}, {0, 1}));
    }
    meridian = std::move(finer);
    meridian.is_graded = true;
  }
}

MeridianMesh mesh_meridian(const Meridian& meridian, int order, double cell) {
  return Builder(meridian, order, cell).build();
}

double longest_side(const Meridian& meridian) {
  double longest = 0;
  for (const auto& block : meridian.blocks) {
    for (std::size_t side = 0; side < 4; ++side) {
      longest = std::max(longest, side_length(block, side));
    }
  }
  return longest;
}

MeridianSize measure(const Meridian& meridian) {
  constexpr int order = 8;
  const auto mesh = mesh_meridian(meridian, order, longest_side(meridian));
  MeridianSize size;
  size.low = size.high = mesh.nodes.front().y();
  for (const auto& x : mesh.nodes) {
    size.largest_radius = std::max(size.largest_radius, x.x());
    size.low = std::min(size.low, x.y());
    size.high = std::max(size.high, x.y());
  }
  // Green's theorem with the chords between nodes: right to a percent or better.
  double outline = 0;
  for (std::size_t k = 0; k < mesh.boundary.size(); ++k) {
    if (k % (order + 1) == order) continue;
    const Vec2& a = mesh.nodes[static_cast<std::size_t>(mesh.boundary[k])];
    const Vec2& b = mesh.nodes[static_cast<std::size_t>(mesh.boundary[k + 1])];
    const double dz = b.y() - a.y(), length = (b - a).norm();
    outline += length;
    size.section += dz * (a.x() + b.x()) / 2;
    size.surface += std::numbers::pi * (a.x() + b.x()) * length;
    size.volume += std::numbers::pi / 3 * dz * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x());
  }
  size.wall = 2 * size.section / outline;
  return size;
}

}  // namespace carillon::solvers::mesh
