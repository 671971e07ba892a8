#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "synth/modal/row_response.hpp"
#include "synth/modal/sampled_force.hpp"

namespace carillon::synth::modal {

/// A near-critical mode in free decay, moved on by its exact step: its two exponentials cannot be
/// told apart.
struct NearCritical {
  std::size_t index;  ///< of the mode
  Weights gains;
  LinearForceStep step;
  double displacement, velocity;
  double end;  ///< bound below which it is gone
};

/// Adds what a strike has left to the modes that ring already, or begins them.
void add_motions(const Resonances& resonances, const std::vector<NearCriticalMotion>& motions,
                 std::vector<NearCritical>& modes);
void add_motion(const Resonances& resonances, const NearCriticalMotion& motion,
                std::vector<NearCritical>& modes);

/// Adds the modes' next samples and moves them on.
void ring_on(const Resonances& resonances, std::span<NearCritical> modes,
             std::span<double> samples);

/// Takes out modes that are gone.
void drop_gone(const Resonances& resonances, std::vector<NearCritical>& modes);

}  // namespace carillon::synth::modal
