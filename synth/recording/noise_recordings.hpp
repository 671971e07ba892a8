#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/random.hpp"

namespace carillon::synth::recording {

/// How recordings of noise are read.
struct RecordingOptions {
  double sample_rate = 44100;                   ///< [Hz] of what is drawn
  int channel = 0;                              ///< 1, 2, ...: that channel; 0: mean of all
  std::size_t memory = std::size_t{256} << 20;  ///< [byte] of resampled recordings that are kept
};

/// A recording that can be used, as it lies in its file.
struct Recording {
  std::string name;            ///< path within the folder
  std::string content;         ///< SHA-256 of rate and samples (after the choice of channel)
  double sample_rate = 0;      ///< [Hz]
  std::size_t frames = 0;      ///< samples
  double rms = 0;              ///< of what is audible; what is drawn is divided by it
  double audible_seconds = 0;  ///< without silent stretches
};

/// A stretch of a recording in a drawn noise.
struct NoiseSegment {
  std::string name;     ///< of the recording
  double start = 0;     ///< [s] in its file
  double duration = 0;  ///< [s], cross-fades included
};

/// Noise joined from recordings.
struct NoiseDraw {
  std::vector<double> samples;
  std::vector<NoiseSegment> segments;  ///< in order
};

/// What can be known of a folder from its list of files and their headers: that it can be read and
/// holds audio that is long enough to be divided. NoiseFolder, which reads the samples, may still
/// refuse it (silence, files that are the same).
/// @throws InputError  no folder, no files, none that libsndfile reads, or altogether too short for
///                     `parts` parts
void check_noise_folder(const std::filesystem::path& folder, std::size_t parts);

/// A folder of noise recordings.
///
/// All formats that libsndfile reads, any rate from 1 kHz to 1 MHz, any number of channels,
/// subfolders included, hidden files not. Files are taken in the order of their names; what is
/// drawn depends on their content, the options and the random stream, never on what was drawn
/// before. Of recordings with equal content only the first is used. Stretches of 0.1 s or more
/// below -100 dB of full scale count as silence: they are cut out, and what lies around them is
/// used separately.
///
/// One folder belongs to one thread.
class NoiseFolder {
 public:
  /// Reads every file once and keeps what they hold, not the samples.
  /// @throws InputError  the folder cannot be read or has no usable recording; says what is wrong
  ///                     with each
  NoiseFolder(const std::filesystem::path& folder, const RecordingOptions& options);
  ~NoiseFolder();
  NoiseFolder(NoiseFolder&&) noexcept;

  const std::vector<Recording>& recordings() const;
  /// Files that are not used: "name: reason".
  const std::vector<std::string>& left_out() const;

  /// Whole recordings belong to parts (by their content's hash modulo `parts`). Where some part
  /// would be left with less than 0.1 s, each recording is cut in time into `parts` stretches of
  /// equal length, one for each part. Different parts never share audio.
  ///
  /// `count` samples of one of `parts` parts. A recording (longer ones more often) is entered at a
  /// random place; where it ends, another, or another stretch of it, follows with an equal-power
  /// cross-fade of up to 20 ms. Recordings are brought to the same level (root mean square 1 of
  /// what is audible in the file). Nothing is looped: a recording shorter than what is wanted gives
  /// stretches of random length and place.
  /// @throws InputError  the recordings are too short to be divided into so many parts; a file
  ///                     changed since the folder was opened
  NoiseDraw draw(std::size_t count, std::size_t part, std::size_t parts,
                 core::RandomStream& random);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace carillon::synth::recording
