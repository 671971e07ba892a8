#pragma once

#include "eval/networks/detail/learner_state.hpp"

namespace carillon::eval::networks {

/// Planes of each class against the rest, the classes dealt to the ranks in turn: the same on any
/// number of ranks. A rank holds all samples, or as many as `memory` takes.
/// @throws InputError  a sample that is not finite
/// @note Collective on the ranks.
Trained train_linear_machines(Learner::State& learner, learning::SampleSource& source,
                              const learning::LabelledSamples& samples, const LearningRanks& ranks,
                              const LearningWatch& watch);

}  // namespace carillon::eval::networks
