#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "render/maps/surface_map.hpp"

namespace carillon::render::maps {
namespace {

using Row = Eigen::Array4d;

/// The four texels around a place along one axis, and how far it lies between the middle two.
struct Taps {
  std::array<int, 4> at{};
  bool side_by_side = false;  ///< at[k] is at[0] + k
  double t = 0;
};

/// @param place  in texels from the first one's centre
Taps taps_at(double place, int count, bool repeats) {
  Taps taps;
  // Where nothing can be said (no number, or too far for one), the result is no number.
  if (!(std::abs(place) < 1e15)) {
    taps.t = std::numeric_limits<double>::quiet_NaN();
    return taps;
  }
  auto first = static_cast<std::int64_t>(place);
  first -= place < static_cast<double>(first) ? 1 : 0;
  taps.t = place - static_cast<double>(first);
  if (first >= 1 && first + 2 < count) {
    const int begin = static_cast<int>(first) - 1;
    taps.at = {begin, begin + 1, begin + 2, begin + 3};
    taps.side_by_side = true;
    return taps;
  }
  if (repeats) {
    const std::int64_t turn = first % count;
    int next = static_cast<int>(turn < 0 ? turn + count : turn);
    next = next == 0 ? count - 1 : next - 1;
    for (int& tap : taps.at) {
      tap = next;
      next = next + 1 == count ? 0 : next + 1;
    }
  } else {
    const std::int64_t last = count - 1;
    for (int k = 0; k < 4; ++k) {
      taps.at[static_cast<std::size_t>(k)] =
          static_cast<int>(std::clamp<std::int64_t>(first - 1 + k, 0, last));
    }
  }
  return taps;
}

/// Weights of the uniform cubic B-spline and its derivatives, in terms of the first texel inside
/// and of differences of neighbours: what is constant has exactly no slope.
struct Weights {
  double w0, w1, w2;  ///< value = c1 + w0 (c1 - c0) + w1 (c2 - c1) + w2 (c3 - c2)
  double q0, q1, q2;  ///< slope
  double t;           ///< curvature = (1 - t) (c0 - 2 c1 + c2) + t (c1 - 2 c2 + c3)
};

Weights weights_at(double t) {
  const double s = 1 - t;
  const double near = s * s * s / 6, far = t * t * t / 6;
  const double middle = (1 + 3 * t * (1 + t * s)) / 6;  // of the third texel
  return {-near, middle + far, far, s * s / 2, 0.5 + t * s, t * t / 2, t};
}

template <class T>
T value(const Weights& w, const T& c1, const T& d0, const T& d1, const T& d2) {
  return c1 + w.w0 * d0 + w.w1 * d1 + w.w2 * d2;
}
template <class T>
T slope(const Weights& w, const T& d0, const T& d1, const T& d2) {
  return w.q0 * d0 + w.q1 * d1 + w.q2 * d2;
}
template <class T>
T bend(const Weights& w, const T& d0, const T& d1, const T& d2) {
  return (1 - w.t) * (d1 - d0) + w.t * (d2 - d1);
}

double value(const Weights& w, const Row& c) {
  return value(w, c[1], c[1] - c[0], c[2] - c[1], c[3] - c[2]);
}
double slope(const Weights& w, const Row& c) {
  return slope(w, c[1] - c[0], c[2] - c[1], c[3] - c[2]);
}
double bend(const Weights& w, const Row& c) {
  return bend(w, c[1] - c[0], c[2] - c[1], c[3] - c[2]);
}

/// Where a place lies among the texels.
struct Place {
  Taps columns, rows;
  Weights u, v;

  Place(const SurfaceMap& map, const Eigen::Vector2d& uv)
      : columns(taps_at(uv.x() / map.texel - 0.5, map.width, map.repeats)),
        rows(taps_at(uv.y() / map.texel - 0.5, map.height, map.repeats)),
        u(weights_at(columns.t)),
        v(weights_at(rows.t)) {}

  Row row(const SurfaceMap& map, const std::vector<float>& texels, std::size_t k) const {
    const float* begin = texels.data() + static_cast<std::ptrdiff_t>(rows.at[k]) * map.width;
    if (columns.side_by_side) {
      return Eigen::Map<const Eigen::Array4f>(begin + columns.at[0]).cast<double>();
    }
    return {begin[columns.at[0]], begin[columns.at[1]], begin[columns.at[2]], begin[columns.at[3]]};
  }
};

/// The second of the rows around a place, and the differences of neighbours.
struct Patch {
  Row c1, d0, d1, d2;

  Patch(const SurfaceMap& map, const std::vector<float>& texels, const Place& place) {
    const Row c0 = place.row(map, texels, 0), c2 = place.row(map, texels, 2),
              c3 = place.row(map, texels, 3);
    c1 = place.row(map, texels, 1);
    d0 = c1 - c0;
    d1 = c2 - c1;
    d2 = c3 - c2;
  }
};

}  // namespace

SurfaceDetail detail_at(const SurfaceMap& map, const Eigen::Vector2d& uv) {
  const Place place(map, uv);
  const double per_texel = 1 / map.texel;
  SurfaceDetail detail;
  const auto along_v = [&](const Patch& p) -> Row {
    return value<Row>(place.v, p.c1, p.d0, p.d1, p.d2);
  };
  const auto slope_v = [&](const Patch& p) -> Row { return slope<Row>(place.v, p.d0, p.d1, p.d2); };
  if (map.relief()) {
    const Patch patch(map, map.heights, place);
    const Row a = along_v(patch), b = slope_v(patch);
    const Row c = bend<Row>(place.v, patch.d0, patch.d1, patch.d2);
    detail.height = value(place.u, a);
    detail.slope = Eigen::Vector2d(slope(place.u, a), value(place.u, b)) * per_texel;
    const double mixed = slope(place.u, b);
    detail.curvature << bend(place.u, a), mixed, mixed, value(place.u, c);
    detail.curvature *= per_texel * per_texel;
    return detail;
  }
  const std::array<const std::vector<float>*, 2> slopes = {&map.slopes_u, &map.slopes_v};
  for (int axis = 0; axis < 2; ++axis) {
    const Patch patch(map, *slopes[static_cast<std::size_t>(axis)], place);
    const Row a = along_v(patch), b = slope_v(patch);
    detail.slope[axis] = value(place.u, a);
    detail.curvature(axis, 0) = slope(place.u, a) * per_texel;
    detail.curvature(axis, 1) = value(place.u, b) * per_texel;
  }
  return detail;
}

double height_at(const SurfaceMap& map, const Eigen::Vector2d& uv) {
  if (!map.relief()) return 0;
  const Place place(map, uv);
  const Patch p(map, map.heights, place);
  return value(place.u, value<Row>(place.v, p.c1, p.d0, p.d1, p.d2));
}

Eigen::Vector2d slope_at(const SurfaceMap& map, const Eigen::Vector2d& uv) {
  const Place place(map, uv);
  if (map.relief()) {
    const Patch p(map, map.heights, place);
    const double per_texel = 1 / map.texel;
    return {slope(place.u, value<Row>(place.v, p.c1, p.d0, p.d1, p.d2)) * per_texel,
            value(place.u, slope<Row>(place.v, p.d0, p.d1, p.d2)) * per_texel};
  }
  const Patch p(map, map.slopes_u, place), q(map, map.slopes_v, place);
  return {value(place.u, value<Row>(place.v, p.c1, p.d0, p.d1, p.d2)),
          value(place.u, value<Row>(place.v, q.c1, q.d0, q.d1, q.d2))};
}

Vec3 texel_normal(const SurfaceMap& map, const Eigen::Vector2d& uv) {
  const Eigen::Vector2d centre = ((uv / map.texel).array().floor() + 0.5) * map.texel;
  if (map.relief()) return normal_of(slope_at(map, centre));
  const Place place(map, centre);  // its second texel either way, or the first after rounding
  const auto nearest = [](const Taps& taps) {
    return static_cast<std::size_t>(taps.at[taps.t < 0.5 ? 1 : 2]);
  };
  const std::size_t texel =
      nearest(place.rows) * static_cast<std::size_t>(map.width) + nearest(place.columns);
  return normal_of({map.slopes_u[texel], map.slopes_v[texel]});
}

SurfaceMap normal_map_of(const SurfaceMap& relief) {
  if (!relief.relief()) return relief;
  SurfaceMap map = relief;
  map.heights.clear();
  map.slopes_u.reserve(relief.heights.size());
  map.slopes_v.reserve(relief.heights.size());
  for (int j = 0; j < relief.height; ++j) {
    for (int i = 0; i < relief.width; ++i) {
      const Eigen::Vector2d slope =
          slope_at(relief, Eigen::Vector2d(i + 0.5, j + 0.5) * relief.texel);
      map.slopes_u.push_back(static_cast<float>(slope.x()));
      map.slopes_v.push_back(static_cast<float>(slope.y()));
    }
  }
  return map;
}

}  // namespace carillon::render::maps
