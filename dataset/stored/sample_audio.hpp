#pragma once

#include <cstdint>
#include <vector>

#include "core/audio.hpp"
#include "core/hdf5_rows.hpp"

namespace carillon::dataset::stored {

/// Sounds of a dataset as clips, one channel for each listener.
class SampleAudio {
 public:
  /// @throws InputError  no sounds
  explicit SampleAudio(const core::Hdf5Group& index);

  /// What nothing is lost in: 16 bits where so many are stored.
  core::SampleFormat format() const { return format_; }
  int sample_rate() const { return sample_rate_; }
  std::size_t listeners() const { return listeners_; }

  /// Clips of rows [first, first + count).
  /// @throws FileError  names the shard that is lost
  std::vector<core::AudioClip> read(std::uint64_t first, std::uint64_t count) const;

 private:
  core::Hdf5Rows rows_;
  core::SampleFormat format_;
  int sample_rate_;
  std::size_t listeners_ = 1, samples_ = 0;
};

}  // namespace carillon::dataset::stored
