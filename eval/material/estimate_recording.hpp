#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/audio.hpp"
#include "core/trace.hpp"
#include "eval/features/extract_features.hpp"
#include "eval/material/estimate_material.hpp"
#include "eval/material/pitch_estimate.hpp"
#include "solvers/modes/modes.hpp"
#include "synth/material/material.hpp"

namespace carillon::eval::material {

/// Options of an estimate as a person gives them: quantities with their units, "" where the default
/// is meant.
struct EstimateArguments {
  static constexpr std::size_t max_starts = 1000;
  std::string metric = "pitches";  ///< or "hybrid"
  std::string model = "rayleigh";
  std::string heard = "velocity";
  std::string contact_time;            ///< "": sought
  std::string poisson_ratio, density;  ///< "": the assumed material's; density then unknown
  std::string onset, rt60;
  std::size_t starts = 8;
  std::uint64_t seed = 1;
};

/// @throws InputError  a value that cannot be read or is out of range; names the option
MaterialOptions material_options(const EstimateArguments& arguments);

/// What the object is taken to be of while its material is sought, as assumed_material().
/// @param named  a preset or constants; "": none
/// @throws InputError  as material_options() and assumed_material()
synth::material::Material assumed_material(const std::string& named,
                                           const EstimateArguments& arguments);

/// The object's density, where it was given [kg/m^3].
/// @throws InputError  it cannot be read
std::optional<double> known_density(const EstimateArguments& arguments);

/// What an estimate is made by.
enum class Metric {
  pitches,  ///< the likelihood of the frequencies alone (pitch_posterior.hpp)
  hybrid    ///< the papers': spectrograms and match ratios, of a known strike (hybrid_metric.hpp)
};

/// @throws InputError  no such name, or what does not go together: names the options
/// @param struck    whether the point struck is known
/// @param recorded  number of recordings
/// @param output    whether the estimate is to be made a sound
Metric checked_metric(const EstimateArguments& arguments, bool struck, std::size_t recorded,
                      bool output);

/// Poisson's ratios to be tried: the one that is given, by itself or with the material, or 0.05 to
/// 0.45 in steps of 0.05 for the metric of pitches.
/// @throws InputError  none is given to the hybrid metric; and as assumed_material()
std::vector<double> poisson_ratios(const std::string& named, const EstimateArguments& arguments);

/// One channel of a recorded strike, and the modes that it shows.
struct HeardRecording {
  std::vector<double> samples;  ///< full scale 1
  features::FeatureSet set;
  std::vector<double> rt60;  ///< of the room, as FeatureOptions has it
};

/// @param name  of the recording, for messages
/// @throws InputError  no modes can be heard, a sample that is not finite, a value that cannot be
///                     read
HeardRecording listen(std::vector<double> samples, double sample_rate,
                      const EstimateArguments& arguments, const std::string& name);

/// Where an object was struck.
struct StruckPlace {
  Vec3 at;                             ///< [m]; the nearest point of the surface is meant
  std::optional<Vec3> direction = {};  ///< of the force, of any length; none: inward
};

/// @throws InputError  a direction without length
StruckPlace struck_place(const Vec3& at, const std::optional<Vec3>& direction);

/// An estimate, and what it sounds like.
struct RecordedMaterial {
  MaterialEstimate estimate;
  core::AudioClip resynthesis;  ///< as long as the recording, its strike at the recording's onset
};

/// The material of an object from a recording of it.
/// @param materials  that it was solved in: one, of assumed_material()
/// @param object     its name, for messages
/// @param trace      stage `search` is added
/// @throws InputError  several regions, and as estimate_material()
RecordedMaterial estimate_recording(const HeardRecording& recording,
                                    const solvers::modes::Modes& modes,
                                    std::span<const synth::material::Material> materials,
                                    const StruckPlace& place, const MaterialOptions& options,
                                    const std::string& object, core::Trace& trace);

/// The material of an object from the pitches of recordings of it, with modes at the Poisson's
/// ratios that are tried.
/// @param modes     of assumed_material() at each ratio
/// @param place     where it was struck, if that is known: of every recording
/// @param trace     stage `search` is added
/// @throws InputError  no modes
PitchEstimate estimate_from_recordings(std::span<const HeardRecording> recordings,
                                       std::span<const solvers::modes::Modes> modes,
                                       std::span<const double> ratios,
                                       const synth::material::Material& assumed,
                                       const std::optional<StruckPlace>& place,
                                       const damping::DampingLaw& law, core::Trace& trace);

}  // namespace carillon::eval::material
