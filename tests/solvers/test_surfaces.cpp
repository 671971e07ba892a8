#include "tests/solvers/test_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace carillon::test {
namespace {

using solvers::mesh::Triangle;

/// Vertices that are told apart by place.
class Builder {
 public:
  std::int32_t vertex(const Vec3& p) {
    const std::array<long, 3> key{std::lround(p.x() * 1e9), std::lround(p.y() * 1e9),
                                  std::lround(p.z() * 1e9)};
    const auto [entry, fresh] =
        index_.try_emplace(key, static_cast<std::int32_t>(mesh.vertices.size()));
    if (fresh) mesh.vertices.push_back(p);
    return entry->second;
  }
  void triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Triangle t{vertex(a), vertex(b), vertex(c)};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles.push_back(t);
  }
  SurfaceMesh mesh;

 private:
  std::map<std::array<long, 3>, std::int32_t> index_;
};

}  // namespace

SurfaceMesh box_surface(const Vec3& sides, int n) {
  Builder builder;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (int end = 0; end < 2; ++end) {
      for (int k = 0; k < n * n; ++k) {
        const auto at = [&](int i, int j) {
          Vec3 p = Vec3::Zero();
          p[axis] = end * sides[axis];
          p[u] = sides[u] * (k / n + i) / n;
          p[v] = sides[v] * (k % n + j) / n;
          return p;
        };
        const Vec3 a = at(0, 0), b = at(end, 1 - end), c = at(1, 1), d = at(1 - end, end);
        builder.triangle(a, b, c);
        builder.triangle(a, c, d);
      }
    }
  }
  return builder.mesh;
}

SurfaceMesh sphere_surface(double radius, int n) {
  Builder builder;
  for (int octant = 0; octant < 8; ++octant) {
    const Vec3 sign((octant & 1) ? -1 : 1, (octant & 2) ? -1 : 1, (octant & 4) ? -1 : 1);
    const bool mirrored = sign.prod() < 0;
    const auto at = [&](int i, int j) -> Vec3 {
      return radius * Vec3(i, j, n - i - j).cwiseProduct(sign).normalized();
    };
    const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
      mirrored ? builder.triangle(a, c, b) : builder.triangle(a, b, c);
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        add(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < n) add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
    }
  }
  return builder.mesh;
}

SurfaceMesh turned_surface(const std::vector<std::array<double, 2>>& profile, int segments) {
  Builder builder;
  const auto at = [&](std::size_t i, int s) {
    const auto& [r, z] = profile[i % profile.size()];
    const double angle = 2 * M_PI * (s % segments) / segments;
    return Vec3(r * std::cos(angle), r * std::sin(angle), z);
  };
  for (std::size_t i = 0; i < profile.size(); ++i) {
    for (int s = 0; s < segments; ++s) {
      builder.triangle(at(i, s), at(i, s + 1), at(i + 1, s + 1));
      builder.triangle(at(i, s), at(i + 1, s + 1), at(i + 1, s));
    }
  }
  return builder.mesh;
}

SurfaceMesh torus_surface(double radius, double tube, int segments) {
  std::vector<std::array<double, 2>> profile;
  for (int i = 0; i < segments; ++i) {
    const double angle = 2 * M_PI * i / segments;
    profile.push_back({radius + tube * std::cos(angle), tube * std::sin(angle)});
  }
  return turned_surface(profile, 2 * segments);
}

SurfaceMesh tube_surface(double radius, double wall, double length, int segments) {
  std::vector<std::array<double, 2>> profile;
  for (int i = 0; i < segments; ++i) {
    profile.push_back({radius + wall / 2, length * i / segments});
  }
  for (int i = segments; i > 0; --i) {
    profile.push_back({radius - wall / 2, length * i / segments});
  }
  profile.push_back({radius - wall / 2, 0});
  profile.insert(profile.begin() + segments, {radius + wall / 2, length});
  return turned_surface(profile, 2 * segments);
}

SurfaceMesh bowl_surface(double radius, double wall, int segments) {
  std::vector<std::array<double, 2>> profile;
  for (int i = 0; i <= segments; ++i) {
    const double angle = M_PI / 2 * i / segments;
    profile.push_back({radius * std::sin(angle), -radius * std::cos(angle)});
  }
  for (int i = segments; i >= 0; --i) {
    const double angle = M_PI / 2 * i / segments;
    profile.push_back({(radius - wall) * std::sin(angle), (wall - radius) * std::cos(angle)});
  }
  return turned_surface(profile, 4 * segments);
}

SurfaceMesh moved(SurfaceMesh mesh, const Vec3& by) {
  for (Vec3& v : mesh.vertices) v += by;
  return mesh;
}

SurfaceMesh together(const SurfaceMesh& a, const SurfaceMesh& b) {
  SurfaceMesh both = a;
  const auto first = static_cast<std::int32_t>(a.vertices.size());
  both.vertices.insert(both.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Triangle& t : b.triangles) {
    both.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return both;
}

SurfaceMesh turned_over(SurfaceMesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

SurfaceMesh damaged(SurfaceMesh mesh, Damage damage, double fraction, std::mt19937_64& random) {
  const auto count = static_cast<std::size_t>(
      std::max(1.0, std::round(fraction * static_cast<double>(mesh.triangles.size()))));
  std::vector<std::size_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), random);
  order.resize(count);
  std::sort(order.rbegin(), order.rend());
  for (const std::size_t t : order) {
    Triangle& triangle = mesh.triangles[t];
    switch (damage) {
      case Damage::dropped:
        mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t));
        break;
      case Damage::flipped:
        std::swap(triangle[1], triangle[2]);
        break;
      case Damage::doubled: {
        Triangle twin = triangle;
        if (t % 2 == 0) std::swap(twin[1], twin[2]);
        mesh.triangles.push_back(twin);
        break;
      }
      case Damage::seams:
        for (std::int32_t& v : triangle) {
          mesh.vertices.push_back(Vec3(mesh.vertices[static_cast<std::size_t>(v)]));
          v = static_cast<std::int32_t>(mesh.vertices.size()) - 1;
        }
        break;
    }
  }
  return mesh;
}

}  // namespace carillon::test
