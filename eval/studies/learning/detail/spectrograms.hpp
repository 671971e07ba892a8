#pragma once

#include <optional>
#include <string>
#include <vector>

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

/// Of one dataset two principal components of its sounds, what the filters of the network's first
/// convolution make of one, and of every class the spectrogram that excites it most. Pictures are
/// bands x frames, as many bands as `bands` says.
struct DatasetSpectrograms {
  std::string name;
  std::size_t bands = 0;
  std::vector<double> band_hz;            ///< of each band its middle; empty where it is not known
  std::vector<double> frame_s;            ///< of each frame its middle, likewise
  std::vector<std::string> keys, labels;  ///< of the sounds
  std::vector<double> mean;               ///< picture
  double mean_square = 0;
  struct Component {
    double fraction = 0;           ///< of the variance
    double explained = core::nan;  ///< fraction of it that the labels explain; NaN of none
    std::vector<double> picture;
    std::vector<double> coordinates;  ///< of each sound
  };
  std::vector<Component> components;
  /// Of filters that differ: first the one that is excited most, then always the one that is least
  /// alike to those before, of those excited a tenth as much.
  struct Activations {
    std::size_t sound = 0;  ///< number of the sound nearest to the mean along both components
    std::vector<double> spectrogram;  ///< picture
    std::size_t bands = 0;            ///< of the filters' pictures: where their kernel fits
    struct Filter {
      std::size_t number = 0;
      std::vector<double> picture;
    };
    std::vector<Filter> filters;
  };
  Activations activations;
  struct Exciting {
    std::string name;  ///< of the class
    std::vector<double> picture;
  };
  std::vector<Exciting> exciting;
};

/// @return of each dataset, on rank 0; nothing where it was interrupted
/// @note Collective on world.
std::optional<std::vector<DatasetSpectrograms>> study_spectrograms(
    const SpectrogramStudy& study, const EvaluatedDatasets& datasets, MPI_Comm world);

}  // namespace carillon::eval::studies
