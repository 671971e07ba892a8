#include "solvers/elements/node_numbering.hpp"

#include <algorithm>
#include <unordered_map>

#include "solvers/elements/lagrange.hpp"

namespace carillon::solvers::elements {
namespace {

struct HashTriple {
  std::size_t operator()(const std::array<std::int32_t, 3>& key) const {
    std::uint64_t h = 0;
    for (std::int32_t k : key)
      h = (h ^ static_cast<std::uint32_t>(k)) * 0x9E3779B97F4A7C15ull, h ^= h >> 29;
    return h;
  }
};

/// One lattice point of an element as its edge or face sees it.
struct Place {
  std::array<std::int32_t, 3> vertices{-1, -1, -1};  ///< ascending; the third is -1 on an edge
  std::array<int, 3> weights{};                      ///< of those vertices
};

Place place_of(const Corners& corners, const std::array<int, 4>& lattice) {
  std::array<std::pair<std::int32_t, int>, 3> part{{{-1, 0}, {-1, 0}, {-1, 0}}};
  std::size_t count = 0;
  for (std::size_t i = 0; i < 4; ++i)
    if (lattice[i] > 0) part[count++] = {corners[i], lattice[i]};
  std::sort(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(count));
  Place place;
  for (std::size_t i = 0; i < count; ++i) {
    place.vertices[i] = part[i].first;
    place.weights[i] = part[i].second;
  }
  return place;
}

}  // namespace

NodeNumbering number_nodes(std::span<const Corners> tetrahedra, std::int32_t vertex_count,
                           int order) {
  const auto& lattice = tetrahedron_lattice(order);
  const std::size_t per_element = lattice.size();
  NodeNumbering numbering;
  numbering.elements.assign(tetrahedra.size() * per_element, -1);
  numbering.first_use.assign(static_cast<std::size_t>(vertex_count), -1);

  // One pass for each dimension keeps corners, edges, faces and insides apart in the numbering.
  for (std::size_t e = 0; e < tetrahedra.size(); ++e)
    for (std::size_t i = 0; i < 4; ++i) {
      const auto at = e * per_element + i;
      const std::int32_t v = tetrahedra[e][i];
      numbering.elements[at] = v;
      auto& first = numbering.first_use[static_cast<std::size_t>(v)];
      if (first < 0) first = static_cast<std::int64_t>(at);
    }
  for (int dimension = 1; dimension <= 3; ++dimension) {
    const int nodes_on_part = dimension == 1   ? order - 1
                              : dimension == 2 ? (order - 1) * (order - 2) / 2
                                               : 1;
    std::unordered_map<std::array<std::int32_t, 3>, std::int32_t, HashTriple> first_of_part;
    for (std::size_t e = 0; e < tetrahedra.size(); ++e)
      for (std::size_t i = 4; i < per_element; ++i) {
        const auto zeros = std::count(lattice[i].begin(), lattice[i].end(), 0);
        if (3 - zeros != dimension) continue;
        const auto at = e * per_element + i;
        std::int32_t node = static_cast<std::int32_t>(numbering.first_use.size());
        if (dimension < 3) {
          const Place place = place_of(tetrahedra[e], lattice[i]);
          const auto [entry, is_new] = first_of_part.try_emplace(place.vertices, node);
          if (is_new)
            numbering.first_use.resize(
                numbering.first_use.size() + static_cast<std::size_t>(nodes_on_part), -1);
          // Along an edge nodes count from its lower vertex; in a face by weights, whose rank
          // among all inner triples is w0-1 full rows of shrinking length, then w1-1.
          const int w0 = place.weights[0], w1 = place.weights[1];
          int rank = w1 - 1;
          if (dimension == 2) {
            rank = w1 - 1;
            for (int row = 1; row < w0; ++row) rank += order - 1 - row;
          }
          node = entry->second + rank;
        } else {
          numbering.first_use.push_back(-1);
        }
        numbering.elements[at] = node;
        auto& first = numbering.first_use[static_cast<std::size_t>(node)];
        if (first < 0) first = static_cast<std::int64_t>(at);
      }
  }
  return numbering;
}

}  // namespace carillon::solvers::elements
