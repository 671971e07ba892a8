#include "synth/motion/contact_path.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace carillon::synth::motion {

ContactPath::ContactPath(std::vector<Vec3> points, double step) : step_(step) {
  if (points.empty() || !(step > 0)) throw core::InputError("contact path: no points");
  for (const Vec3& point : points) {
    if (!point.allFinite()) throw core::InputError("contact path: a point is not finite");
  }
  const Vec3 first = points.front();
  const Vec3 last = points.back();
  const std::size_t count = points.size();
  const Vec3 begin = count > 1 ? Vec3(2 * first - points[1]) : first;
  const Vec3 end = count > 1 ? Vec3(2 * last - points[count - 2]) : last;
  control_.push_back(begin);
  control_.insert(control_.end(), points.begin(), points.end());
  control_.push_back(end);
  control_.push_back(2 * end - last);
}

ContactPath::Place ContactPath::at(double time) const {
  // Points 0 to count, the step after the last included.
  const double place = std::clamp(time / step_, 0.0, static_cast<double>(control_.size() - 3));
  const auto k = std::min(static_cast<std::size_t>(place), control_.size() - 4);
  const double t = place - static_cast<double>(k);
  const Vec3 &a = control_[k], &b = control_[k + 1], &c = control_[k + 2], &d = control_[k + 3];
  // By differences, so that a contact that rests has a velocity of exactly 0.
  const Vec3 ab = b - a, bc = c - b, cd = d - c;
  const double s = 1 - t;
  Place result;
  result.point =
      b - s * s * s / 6 * ab + ((1 + 3 * t * (1 + t * s)) / 6) * bc + t * t * t / 6 * (bc + cd);
  result.velocity = (s * s / 2 * ab + (0.5 + t * s) * bc + t * t / 2 * cd) / step_;
  result.acceleration = (s * (bc - ab) + t * (cd - bc)) / (step_ * step_);
  return result;
}

double ContactPath::fastest(std::size_t step) const {
  double longest = 0;
  for (std::size_t k = step; k < step + 3; ++k) {
    longest = std::max(longest, (control_[k + 1] - control_[k]).norm());
  }
  return longest / step_;
}

}  // namespace carillon::synth::motion
