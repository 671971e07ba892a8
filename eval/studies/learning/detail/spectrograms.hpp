#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "eval/studies/learning/run_trainings.hpp"

namespace carillon::eval::studies {

/// What `evaluate.spectrograms` asks for: what spectrograms differ by, and what a network looks for
/// in them.
struct SpectrogramStudy {
  LearningConfig learning;
  learning::TaskSpec task;
  learning::Method method;   ///< on spectrograms alone
  std::string color;         ///< column of the labels in the scatter plot
  std::size_t sounds = 420;  ///< of each dataset, for the components (Sterling 2019, section 6.3.1)
};

/// @throws ConfigError
SpectrogramStudy read_spectrogram_study(core::ConfigNode& node, core::ConfigNode& root,
                                        const std::string& file);

/// Of each dataset two principal components of its sounds, where these lie on them and how much of
/// each the labels explain; and of every class the spectrogram that excites it most.
/// @return on rank 0; nothing where it was interrupted
/// @note Collective on the context's world.
std::optional<nlohmann::ordered_json> study_spectrograms(const SpectrogramStudy& study,
                                                         const EvaluatedDatasets& datasets,
                                                         const mpi::Context& context);

}  // namespace carillon::eval::studies
