#pragma once

#include "eval/studies/evaluation.hpp"

namespace carillon::eval::studies {

/// Sections of `evaluate:` that need libtorch; docs/learning.md.

/// `classification`: how well are shapes and materials told apart?
RunEvaluation read_classification(core::ConfigNode& node, core::ConfigNode& root,
                                  const EvaluatedDatasets& datasets);
/// `transfer`: does it hold in another condition?
RunEvaluation read_transfer_section(core::ConfigNode& node, core::ConfigNode& root,
                                    const EvaluatedDatasets& datasets);
/// `spectrograms`: what do they differ by, and what does a network look for?
RunEvaluation read_spectrograms(core::ConfigNode& node, core::ConfigNode& root,
                                const EvaluatedDatasets& datasets);

}  // namespace carillon::eval::studies
