#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/random.hpp"

namespace carillon::synth::room {

/// How measured responses are read.
struct MeasuredOptions {
  double sample_rate = 44100;  ///< [Hz] of the clips
  std::size_t count = 44100;   ///< samples of the clips: what comes later is not heard
  int channel = 0;             ///< 1, 2, ...: that channel; 0: every channel is a response
  std::size_t parts = 1;       ///< of the data set, which share no file
};

/// A response that was measured in a room, as clips are convolved with it.
struct MeasuredResponse {
  std::string name;            ///< of the file, within the folder
  int channel = 1;             ///< of the file, from 1
  std::vector<float> samples;  ///< from the direct sound on, whose energy is 1
};

/// The direct sound of a measured response: what comes within this time of its onset [s].
inline constexpr double direct_seconds = 0.0025;

/// A response from its direct sound on at another rate. The onset is the first sample within 20 dB
/// of the largest magnitude (ISO 3382-1); what comes before is cut off. The energy of the direct
/// sound (direct_seconds) becomes 1, so that white noise keeps its level in it, as in a simulated
/// room, whose direct sound is 1 at sample 0.
/// @param samples  at `rate` [Hz]
/// @return  at options.sample_rate, options.count samples at the most, and at least one
/// @throws InputError  no samples, silence, a value that is not finite, the largest magnitude in
/// the last
///                     direct_seconds (of a reversed response, or one that ends in a click), or
///                     nothing below half of the clips' rate
std::vector<float> from_direct_sound(std::span<const double> samples, double rate,
                                     const MeasuredOptions& options);

/// Impulse responses of rooms in files: any format that libsndfile reads, 1 kHz to 1 MHz.
///
/// A folder's files belong to parts as wholes, by the hash of their content modulo the number of
/// parts; where that leaves a part without any, by turns in the order of their hashes. Of files
/// with equal content only the first is used. One file alone is the same in all parts.
class MeasuredResponses {
 public:
  /// Reads and resamples every file once.
  /// @param path  a folder (with its folders; hidden files are passed over), or one file
  /// @throws InputError  no such folder, no file in it, fewer files than parts, or a file that
  ///                     cannot be used; names each of these with its reason
  MeasuredResponses(const std::filesystem::path& path, const MeasuredOptions& options);

  /// In the order of the files' names and of their channels.
  const std::vector<MeasuredResponse>& all() const { return responses_; }
  /// Files that say the same as another: "name: the same as other".
  const std::vector<std::string>& left_out() const { return left_out_; }
  /// One of a part's files and one of its channels, all equally likely.
  const MeasuredResponse& draw(std::size_t part, core::RandomStream& random) const;

 private:
  struct File {
    std::string content;    ///< SHA-256 of rate and samples
    std::size_t first = 0;  ///< of its responses
    std::size_t count = 0;
  };
  void read(const std::filesystem::path& folder, const std::filesystem::path& name,
            const MeasuredOptions& options);
  void divide(const std::string& folder, std::size_t parts);

  std::vector<MeasuredResponse> responses_;
  std::vector<File> files_;
  std::vector<std::string> left_out_;
  std::vector<std::vector<std::size_t>> parts_;  ///< files of each; one list for all of a lone file
};

/// The same, read before by this process with equal arguments from files that have not changed
/// since, as every object of a build asks for it; the last one that was asked for is kept.
/// @throws InputError  as MeasuredResponses
std::shared_ptr<const MeasuredResponses> shared_responses(const std::filesystem::path& path,
                                                          const MeasuredOptions& options);

/// What the headers of the files promise to take in memory, at the most.
struct MeasuredSize {
  std::size_t responses = 0;
  double bytes = 0;
};
/// Files that cannot be read count for nothing.
MeasuredSize measured_size(const std::filesystem::path& path, const MeasuredOptions& options);

}  // namespace carillon::synth::room
