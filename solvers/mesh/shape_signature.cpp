#include "solvers/mesh/shape_signature.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "core/hash.hpp"
#include "solvers/elements/quadrature.hpp"

namespace carillon::solvers::mesh {

namespace {

constexpr int degree = 6;

struct Corners {
  Vec3 p, q, r;
  double area() const { return 0.5 * (q - p).cross(r - p).norm(); }
};

/// Every triangle once, whichever way round it stands.
std::vector<Corners> distinct_triangles(const SurfaceMesh& mesh) {
  std::vector<Corners> all;
  std::set<std::array<std::array<double, 3>, 3>> seen;
  for (const Triangle& t : mesh.triangles) {
    std::array<std::array<double, 3>, 3> key;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& v = mesh.vertices[static_cast<std::size_t>(t[k])];
      key[k] = {v.x(), v.y(), v.z()};
    }
    std::sort(key.begin(), key.end());
    if (!seen.insert(key).second) continue;
    const Corners corners{Vec3(key[0].data()), Vec3(key[1].data()), Vec3(key[2].data())};
    if (corners.area() > 0) all.push_back(corners);
  }
  return all;
}

/// Real solid harmonics r^l C_lm (Racah's normalisation: their squares sum to r^2l over m) of one
/// point, l up to `degree`; [l][m + l]. Helgaker, Jorgensen, Olsen 2000, eq. 6.4.70-6.4.73.
using Harmonics = std::array<std::array<double, 2 * degree + 1>, degree + 1>;

/// Factors of the recurrence from l to l + 1.
struct Recurrence {
  std::array<double, degree> outer;
  Harmonics here{}, below{};  ///< of l and of l - 1

  Recurrence() {
    for (int l = 0; l < degree; ++l) {
      const auto i = static_cast<std::size_t>(l);
      outer[i] = std::sqrt((l == 0 ? 2.0 : 1.0) * (2 * l + 1) / (2 * l + 2));
      for (int m = -l; m <= l; ++m) {
        const double scale = 1 / std::sqrt((l + m + 1) * (l - m + 1));
        here[i][static_cast<std::size_t>(m + l)] = (2 * l + 1) * scale;
        below[i][static_cast<std::size_t>(m + l)] = std::sqrt((l + m) * (l - m)) * scale;
      }
    }
  }
};

void solid_harmonics(const Vec3& at, double r2, Harmonics& s) {
  static const Recurrence factors;
  s[0][0] = 1;
  for (std::size_t l = 0; l < degree; ++l) {
    const auto& here = s[l];
    auto& next = s[l + 1];
    const double low = l == 0 ? 0 : here[0];
    next[2 * l + 2] = factors.outer[l] * (at.x() * here[2 * l] - at.y() * low);
    next[0] = factors.outer[l] * (at.y() * here[2 * l] + at.x() * low);
    for (std::size_t i = 0; i <= 2 * l; ++i) next[i + 1] = factors.here[l][i] * at.z() * here[i];
    for (std::size_t i = 1; i < 2 * l; ++i) {
      next[i + 1] -= factors.below[l][i] * r2 * s[l - 1][i - 1];
    }
  }
}

/// Sums over the surface of r^2k times the solid harmonics of l; [k][l][m + l].
struct Moments {
  std::array<Harmonics, degree / 2 + 1> of_power{};
  double area = 0;

  void add(const Vec3& at, double weight) {
    Harmonics s;
    const double r2 = at.squaredNorm();
    solid_harmonics(at, r2, s);
    double factor = weight;
    for (int k = 0; 2 * k <= degree; ++k, factor *= r2) {
      for (int l = 0; l + 2 * k <= degree; ++l) {
        for (std::size_t m = 0; m < static_cast<std::size_t>(2 * l + 1); ++m) {
          of_power[static_cast<std::size_t>(k)][static_cast<std::size_t>(l)][m] +=
              factor * s[static_cast<std::size_t>(l)][m];
        }
      }
    }
  }

  /// Size of all orders of one degree together: turning the body mixes them, and keeps it.
  double size(int l, int k) const {
    double sum = 0;
    for (const double value : of_power[static_cast<std::size_t>(k)][static_cast<std::size_t>(l)]) {
      sum += value * value;
    }
    return std::sqrt(sum) / area;
  }
};

}  // namespace

ShapeSignature shape_signature(const SurfaceMesh& mesh) {
  const auto& rule = elements::triangle_rule(degree / 2 + 1);
  const std::vector<Corners> triangles = distinct_triangles(mesh);
  if (triangles.empty()) return {};
  const Vec3 near = triangles.front().p;
  Moments moments;
  Vec3 centre = Vec3::Zero();
  for (const Corners& t : triangles) {
    const double area = t.area();
    moments.area += area;
    centre += area / 3 * (t.p + t.q + t.r - 3 * near);
  }
  centre = near + centre / moments.area;
  for (const Corners& t : triangles) {
    const double area = t.area();
    for (std::size_t q = 0; q < rule.size(); ++q) {
      const Eigen::Vector3d& at = rule.barycentric[q];
      moments.add(t.p + at[1] * (t.q - t.p) + at[2] * (t.r - t.p) - centre,
                  2 * area * rule.weights[q]);
    }
  }
  // Unit of length: by the highest moment, so that no other is above 1.
  const double length = std::pow(moments.size(0, degree / 2), 1.0 / degree);
  ShapeSignature signature = {length * length / moments.area};
  for (int l = 0; l <= degree; ++l) {
    for (int k = l == 0 ? 1 : 0; l + 2 * k <= degree; ++k) {
      const bool always_equal = (l == 0 && 2 * k == degree) || (l == 1 && k == 0);
      if (!always_equal) signature.push_back(moments.size(l, k) / std::pow(length, l + 2 * k));
    }
  }
  return signature;
}

double signature_difference(const ShapeSignature& a, const ShapeSignature& b) {
  if (a.empty() || a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

std::string signature_name(const ShapeSignature& signature) {
  constexpr double cell = 0.002;
  std::vector<std::int64_t> cells;
  for (const double value : signature) cells.push_back(std::llround(value / cell));
  if (cells.empty()) return "";
  return core::Sha256().add(std::span<const std::int64_t>(cells)).hex();
}

std::size_t SignatureIndex::add(const ShapeSignature& signature) {
  const std::size_t own = all_.size();
  all_.push_back(signature);
  if (signature.empty()) return own;
  const auto below = [&](std::size_t i, double value) { return all_[i].front() < value; };
  auto at = std::lower_bound(sorted_.begin(), sorted_.end(),
                             signature.front() - same_shape_tolerance, below);
  std::size_t first = own;
  for (; at != sorted_.end() && all_[*at].front() <= signature.front() + same_shape_tolerance;
       ++at) {
    if (signature_difference(all_[*at], signature) <= same_shape_tolerance) {
      first = std::min(first, *at);
    }
  }
  if (first == own) {
    sorted_.insert(std::lower_bound(sorted_.begin(), sorted_.end(), signature.front(), below), own);
  }
  return first;
}

}  // namespace carillon::solvers::mesh
