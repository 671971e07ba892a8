#include "eval/damping/damping_data.hpp"

#include <algorithm>
#include <cmath>

#include "core/numbers.hpp"

namespace carillon::eval::damping {

namespace {

/// Relative error of a decay rate: what is fitted to a room's own fluctuations is known less well,
/// a mode that outlasts the room better.
constexpr double max_error_in_room = 0.06;

void append(std::vector<double>& all, const std::vector<double>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

double room_ceiling(std::span<const double> rt60, double frequency) {
  return 2 * features::room_decay_rate(rt60, frequency);
}

DampingData damping_data(std::span<const features::Feature> features,
                         std::span<const double> rt60) {
  DampingData data;
  bool known = true;
  for (const features::Feature& feature : features) {
    if (feature.reverberant) continue;
    if (!rt60.empty() && feature.decay_rate_error > max_error_in_room * feature.decay_rate)
      continue;
    data.eigenvalues.push_back(features::eigenvalue(feature));
    data.coefficients.push_back(2 * feature.decay_rate);
    data.errors.push_back(2 * feature.decay_rate_error);
    if (!rt60.empty()) {
      // A feature that the extractor has kept is below its ceiling, whatever is rounded.
      data.ceilings.push_back(
          std::max(room_ceiling(rt60, feature.frequency), data.coefficients.back()));
    }
    known = known && std::isfinite(feature.decay_rate_error);
  }
  if (!known) data.errors.clear();
  return data;
}

DampingData reverberant_data(std::span<const features::Feature> modes) {
  DampingData data = damping_data(modes);
  for (const features::Feature& mode : modes) {
    if (!mode.reverberant) data.proportions.push_back(mode.decay_rate_error / mode.decay_rate);
  }
  return data;
}

DampingData joined(std::span<const DampingData> parts) {
  DampingData all;
  bool rooms = false, proportions = false;
  for (const DampingData& part : parts) {
    rooms = rooms || !part.ceilings.empty();
    proportions = proportions || !part.proportions.empty();
  }
  for (const DampingData& part : parts) {
    append(all.eigenvalues, part.eigenvalues);
    append(all.coefficients, part.coefficients);
    append(all.errors, part.errors);
    append(all.ceilings, part.ceilings);
    if (rooms) all.ceilings.resize(all.size(), core::infinity);
    append(all.proportions, part.proportions);
    if (proportions) all.proportions.resize(all.size(), 0.0);
  }
  if (all.errors.size() != all.size()) all.errors.clear();
  return all;
}

}  // namespace carillon::eval::damping
