#include "render/maps/detail/ball_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace carillon::render::maps {
namespace {

constexpr int block = 8;  ///< texels a side

int part(int value) {
  return (value + block - 1) / block;
}

}  // namespace

double BallSearch::reach(double radius, double lowest, double highest) {
  const double drop = std::max(highest - lowest, 0.0);
  return drop >= radius ? radius : std::sqrt(drop * (2 * radius - drop));
}

BallSearch::BallSearch(const SurfaceMap& relief, double radius, double reach,
                       const Eigen::Array2i& first, const Eigen::Array2i& last)
    : relief_(relief), radius_(radius) {
  // A relief that repeats is nowhere nearer than half of it; one that ends is as high beyond its
  // edges as at them.
  const double farthest = std::max(relief.width, relief.height) / 2 + 1;
  const int border = static_cast<int>(std::min(std::ceil(reach / relief.texel) + 1, farthest));
  first_ = first - border;
  width_ = last[0] + border - first_[0];
  height_ = last[1] + border - first_[1];
  blocks_across_ = part(width_);
  blocks_.assign(std::size_t(blocks_across_) * std::size_t(part(height_)),
                 -std::numeric_limits<float>::infinity());
  heights_.reserve(std::size_t(width_) * std::size_t(height_));
  for (int j = 0; j < height_; ++j) {
    for (int i = 0; i < width_; ++i) {
      const Eigen::Vector2d centre(first_[0] + i + 0.5, first_[1] + j + 0.5);
      const auto height = static_cast<float>(height_at(relief, centre * relief.texel));
      heights_.push_back(height);
      float& top =
          blocks_[std::size_t(j / block) * std::size_t(blocks_across_) + std::size_t(i / block)];
      top = std::max(top, height);
    }
  }
  highest_ = *std::max_element(blocks_.begin(), blocks_.end());
}

/// How much lower than the ball's lowest point its underside is at a distance, times -1.
double BallSearch::lift(double square) const {
  const double under = radius_ * radius_ - square;
  return under > 0 ? -square / (radius_ + std::sqrt(under))
                   : -std::numeric_limits<double>::infinity();
}

double BallSearch::value(const Eigen::Vector2d& uv, const Eigen::Vector2d& contact) const {
  const double below = lift((contact - uv).squaredNorm());
  return std::isfinite(below) ? height_at(relief_, contact) + below : below;
}

/// From a place near the contact to the contact: Newton's method, in steps that rise.
double BallSearch::climb(const Eigen::Vector2d& uv, Eigen::Vector2d& contact) const {
  constexpr int max_steps = 20;
  const double longest = std::min(relief_.texel, radius_) / 2;
  double best = value(uv, contact);
  for (int step = 0; step < max_steps; ++step) {
    const SurfaceDetail detail = detail_at(relief_, contact);
    const Eigen::Vector2d off = contact - uv;
    const double under = std::sqrt(std::max(radius_ * radius_ - off.squaredNorm(), 1e-30));
    const Eigen::Vector2d rise = detail.slope - off / under;
    Eigen::Matrix2d bend = -detail.curvature;
    bend += (Eigen::Matrix2d::Identity() + off * off.transpose() / (under * under)) / under;
    // Where the surface curves up more than the ball, straight uphill.
    const bool top = bend.determinant() > 0 && bend.trace() > 0;
    Eigen::Vector2d move =
        top ? Eigen::Vector2d(bend.inverse() * rise) : Eigen::Vector2d(rise.normalized() * longest);
    if (!move.allFinite()) break;
    if (move.norm() > longest) move *= longest / move.norm();
    bool risen = false;
    for (int half = 0; half < 6 && !risen; ++half, move /= 2) {
      const double there = value(uv, contact + move);
      if (!(there > best)) continue;
      best = there;
      contact += move;
      risen = true;
      break;
    }
    if (!risen || move.norm() < 1e-4 * longest) break;
  }
  return best;
}

double BallSearch::height(const Eigen::Vector2d& uv, Eigen::Vector2d& contact) const {
  const double texel = relief_.texel;
  Eigen::Vector2d start = ((contact / texel).array().floor() + 0.5) * texel;
  double best = value(uv, start);
  const double above = value(uv, uv);  // all there is under a ball smaller than a texel
  if (!(best > above)) {
    best = above;
    start = uv;
  }
  const Eigen::Vector2d place = uv / texel - first_.matrix().cast<double>();  // in texels
  double far = reach(radius_, best, highest_) / texel;
  const auto from = [&](double at) { return std::max(0, static_cast<int>(at - far) / block); };
  const auto to = [&](double at, int count) {
    return std::min(part(count), static_cast<int>(std::max(at + far, 0.0)) / block + 1);
  };
  const int first_row = from(place.y()), last_row = to(place.y(), height_);
  const int first_column = from(place.x()), last_column = to(place.x(), width_);
  for (int row = first_row; row < last_row; ++row) {
    const double beyond_v =
        std::max({row * block + 0.5 - place.y(), place.y() - (row * block + block - 0.5), 0.0});
    if (beyond_v > far) continue;
    for (int column = first_column; column < last_column; ++column) {
      const double top =
          blocks_[std::size_t(row) * std::size_t(blocks_across_) + std::size_t(column)];
      if (top <= best) continue;
      const double beyond_u = std::max(
          {column * block + 0.5 - place.x(), place.x() - (column * block + block - 0.5), 0.0});
      const double nearest = (beyond_u * beyond_u + beyond_v * beyond_v) * texel * texel;
      if (top + lift(nearest) <= best) continue;
      const int row_end = std::min(height_, (row + 1) * block);
      const int column_end = std::min(width_, (column + 1) * block);
      for (int j = row * block; j < row_end; ++j) {
        const double off_v = (j + 0.5 - place.y()) * texel;
        for (int i = column * block; i < column_end; ++i) {
          const double height = heights_[std::size_t(j) * std::size_t(width_) + std::size_t(i)];
          if (height <= best) continue;
          const double off_u = (i + 0.5 - place.x()) * texel;
          const double there = height + lift(off_u * off_u + off_v * off_v);
          if (there <= best) continue;
          best = there;
          start = uv + Eigen::Vector2d(off_u, off_v);
          far = reach(radius_, best, highest_) / texel;
        }
      }
    }
  }
  contact = start;
  return climb(uv, contact);
}

}  // namespace carillon::render::maps
