#pragma once

#include <string>
#include <vector>

#include "core/columns.hpp"
#include "core/hdf5.hpp"
#include "core/trace.hpp"
#include "dataset/samples/modes_task.hpp"
#include "render/scene_frame.hpp"

namespace carillon::dataset::samples {

/// A sound with everything that is needed to make it again.
struct SampleResult {
  scene::Sound sound;              ///< its audio is listeners x samples, gain applied
  synth::modal::PointFrame frame;  ///< point and normal, at the sample's size [m]
  double peak = 0;                 ///< largest magnitude in the audio
  double complete_to_hz = 0;
  double pitch_error = 0;                  ///< worst estimated one of the object's modes [cents]
  std::vector<render::SceneFrame> frames;  ///< of a simulation
};

/// Makes samples of one shape from its modes file; modes of a variant are rescaled once.
class SampleMaker {
 public:
  /// @param trace  of the effects; must outlive the maker
  /// @throws FileError  the modes file is missing or damaged
  SampleMaker(const configuration::BuildConfig& config, const plan::Shape& shape,
              const BuildFolders& folders, core::Trace& trace);
  ~SampleMaker();
  /// @param record  takes what the effects drew; may be null
  SampleResult make(const plan::Sample& sample, core::Columns* record);
  /// What rings in a sample: its modes, damped by material, supports and radiation. No sound is
  /// computed.
  synth::modal::RingDown ring(const plan::Sample& sample);
  /// Materials of a variant, one per region.
  const std::vector<synth::material::Material>& materials(std::size_t variant) const;
  /// Factor of a variant's lengths.
  double size(std::size_t variant) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The definition of the spectrograms, as attributes of the dataset `mel`.
void write_mel_attributes(const synth::signal::MelOptions& mel, const core::Hdf5Group& file);

/// Synthesizes the samples of a task and writes their shard, and WAV files and movies when asked
/// for; those that were written are taken away where a later sample fails.
/// @param kept  so many of its first samples are in the shard of an earlier run, from the same
///              inputs: they are copied
/// @return paths of the task's files, relative to the output folder
std::vector<std::string> run_samples_task(const configuration::BuildConfig& config,
                                          const plan::BuildPlan& plan, const plan::BuildTask& task,
                                          const BuildFolders& folders, core::Trace& trace,
                                          std::size_t kept = 0);

}  // namespace carillon::dataset::samples
