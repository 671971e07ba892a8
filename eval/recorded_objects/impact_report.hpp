#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/trace.hpp"
#include "eval/recorded_objects/impact_study.hpp"
#include "synth/material/material.hpp"

namespace carillon::eval::recorded_objects {

/// All that is told of one object.
struct ImpactReport {
  const ImpactFolder& folder;
  const StudyOptions& options;
  const synth::material::Material& material;  ///< as given
  const std::vector<StudiedStrike>& strikes;
  const std::vector<ModelStrike>& model;
  const HeardObject& given;
  const HeardObject* fitted = nullptr;  ///< null without a fit
  const StudyFit* fit = nullptr;
  const std::vector<ModelVariant>& variants;
  std::vector<std::string> remarks;
  const core::Trace& trace;
};

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
