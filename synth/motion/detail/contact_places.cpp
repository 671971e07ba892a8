#include "synth/motion/detail/contact_places.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace carillon::synth::motion {

ContactPlaces::ContactPlaces(const solvers::modes::Modes& modes,
                             const modal::SurfaceSampler& sampler, const LastingContact& contact,
                             std::size_t side, double spacing) {
  if (contact.steps.empty()) throw core::InputError("a lasting contact has no steps");
  const auto point = [&](std::size_t step) { return contact.steps[step].points[side]; };
  way_.push_back(0);
  keys_.push_back(0);
  for (std::size_t step = 1; step < contact.steps.size(); ++step) {
    way_.push_back(way_.back() + (point(step) - point(step - 1)).norm());
    if ((point(step) - point(keys_.back())).norm() > spacing) keys_.push_back(step);
  }
  const std::size_t last = contact.steps.size() - 1;
  if (keys_.back() != last && way_[last] > way_[keys_.back()]) keys_.push_back(last);
  for (const std::size_t key : keys_) {
    shapes_.push_back(modal::shapes_at(modes, sampler.nearest(point(key))));
  }
}

Eigen::MatrixX3d ContactPlaces::shapes(std::size_t step) const {
  step = std::min(step, way_.size() - 1);
  const auto after = std::upper_bound(keys_.begin(), keys_.end(), step);
  if (after == keys_.end()) return shapes_.back();
  const auto key = static_cast<std::size_t>(after - keys_.begin());
  const double begin = way_[keys_[key - 1]], end = way_[keys_[key]];
  const double fraction = end > begin ? (way_[step] - begin) / (end - begin) : 0;
  return shapes_[key - 1] + fraction * (shapes_[key] - shapes_[key - 1]);
}

std::vector<double> smooth_normal_force(const LastingContact& contact, double step, double window) {
  const auto count = static_cast<std::ptrdiff_t>(contact.steps.size());
  const auto reach = static_cast<std::ptrdiff_t>(window / 2 / step);
  std::vector<double> weights;
  for (std::ptrdiff_t i = 0; i <= reach; ++i) {
    const double place = static_cast<double>(i) * step / (window / 2);
    weights.push_back(window > 0 ? (1 + std::cos(std::numbers::pi * place)) / 2 : 1.0);
  }
  std::vector<double> forces;
  for (const ContactStep& at : contact.steps) {
    forces.push_back(std::max(0.0, at.force.dot(at.normal)));
  }
  std::vector<double> smooth;
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    double sum = 0, all = 0;
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, k - reach);
         i <= std::min(count - 1, k + reach); ++i) {
      const double weight = weights[static_cast<std::size_t>(std::abs(i - k))];
      sum += weight * forces[static_cast<std::size_t>(i)];
      all += weight;
    }
    smooth.push_back(sum / all);
  }
  return smooth;
}

Eigen::VectorXd unit_damping(const Eigen::MatrixX3d& shapes, const Vec3& normal, double friction) {
  return friction * shapes.rowwise().squaredNorm() + (1 - friction) * (shapes * normal).cwiseAbs2();
}

}  // namespace carillon::synth::motion
