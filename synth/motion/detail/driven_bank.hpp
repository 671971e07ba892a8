#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "synth/modal/sampled_force.hpp"

namespace carillon::synth::motion {

/// Most modes in one vector: arrays of modes are filled up to whole ones.
inline constexpr std::size_t bank_lanes = 8;
/// Most samples in one stretch: what a stretch needs fits the first-level cache.
inline constexpr std::size_t bank_stretch = 128;

/// Motion of many modes at a sampling instant, and their exact steps to the next.
struct DrivenBank {
  explicit DrivenBank(std::size_t modes);
  void set_step(std::size_t mode, const modal::LinearForceStep& step);

  std::size_t modes = 0;
  std::vector<double> q, v;      ///< displacement and velocity
  std::vector<double> steps[8];  ///< of LinearForceStep, in its order
};

/// Forces on modes over a stretch: the force on mode i at sample t is the sum over parts p of
/// shapes[p][i] courses[p][t].
struct DrivenForces {
  std::vector<const double*> shapes;
  std::vector<const double*> courses;  ///< count + 1 samples each
};

/// Weights of modes' displacement and velocity in an output.
struct BankOutput {
  const double* of_q;
  const double* of_v;
  double* samples;  ///< receives the sum over modes, `count` samples
};

/// Moves the first modes (a multiple of bank_lanes) on by `count` <= bank_stretch samples, and adds
/// what they are at each before the step to the outputs. Sums run over modes in a fixed order;
/// kinds of CPU differ by rounding alone.
void run_bank(DrivenBank& bank, std::size_t modes, const DrivenForces& forces,
              std::span<const BankOutput> outputs, std::size_t count);

}  // namespace carillon::synth::motion
