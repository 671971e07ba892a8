#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/trace.hpp"
#include "eval/recorded_objects/impact_study.hpp"
#include "scene/solved_object.hpp"
#include "synth/material/material.hpp"

namespace carillon::eval::recorded_objects {

/// All that is told of one object.
struct ImpactReport {
  const ImpactFolder& folder;
  StudyOptions options;
  synth::material::Material material;  ///< as given
  std::vector<StudiedStrike> strikes;
  std::vector<ModelStrike> model;
  HeardObject given;
  std::optional<HeardObject> fitted;  ///< none without a fit that determines it
  std::optional<StudyFit> fit;
  std::vector<ModelVariant> variants;
  std::vector<std::string> remarks;
  core::Trace trace;
};

/// The recordings of an object beside its modes, and the material that they speak of.
/// @param rows    one for each strike
/// @param fit     whether a material is fitted
/// @param cache   folder of what is dear to compute; empty: none
/// @return refers to `folder`
/// @throws InputError  several materials, no mode in the band, no recording that says anything
ImpactReport study_object(const ImpactFolder& folder, const std::vector<RecordedStrike>& rows,
                          const scene::SolvedObject& object, const StudyOptions& options, bool fit,
                          const std::filesystem::path& cache);

/// Levels of the pairs that have one, against the recorded modes [dB].
std::vector<double> levels_of(const perception::ModeComparison& modes);

/// docs/realimpact.md names the fields.
nlohmann::json to_json(const ImpactReport& report);
void print_report(const ImpactReport& report);

/// report.json; modes.csv, every recorded and synthetic mode of every strike and variant;
/// spectra.csv, Hiner's spectra side by side; and each strike as it was recorded and as the last
/// variant makes it, as WAV files of one gain, the loudest sample at half of full scale.
/// @throws FileError  cannot be written
void write_report(const std::filesystem::path& folder, const ImpactReport& report);

}  // namespace carillon::eval::recorded_objects
