#include "eval/recorded_objects/impact_contact.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace carillon::eval::recorded_objects {

namespace {

constexpr double threshold = 0.02;  // of the maximum; below, it is noise

}  // namespace

ImpactContact contact_of(std::span<const double> force, double sample_rate) {
  const auto top = std::max_element(force.begin(), force.end());
  if (top == force.end() || !(*top > 0)) {
    throw core::InputError("the force is nowhere above zero",
                           "--contact-time says how long the contact was");
  }
  const auto below = [limit = threshold * *top](double value) { return value < limit; };
  const auto begin = std::find_if(std::make_reverse_iterator(top), force.rend(), below).base();
  const auto end = std::find_if(top, force.end(), below);
  double sum = 0, first = 0, second = 0;
  for (auto at = begin; at != end; ++at) {
    const auto time = static_cast<double>(at - begin);
    sum += *at;
    first += *at * time;
    second += *at * time * time;
  }
  const double middle = first / sum;
  const double variance = std::max(0.0, second / sum - middle * middle);
  // Variance of (1 - cos(2 pi t / T)) / T.
  const double of_cosine = 1.0 / 12 - 0.5 / (std::numbers::pi * std::numbers::pi);
  const double duration = std::sqrt(variance / of_cosine);
  const double start = static_cast<double>(begin - force.begin()) + middle - 0.5 * duration;
  return {std::max(0.0, start) / sample_rate, duration / sample_rate};
}

}  // namespace carillon::eval::recorded_objects
