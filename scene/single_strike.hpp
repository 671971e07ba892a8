#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/trace.hpp"
#include "scene/scene.hpp"
#include "scene/solved_object.hpp"
#include "scene/strikes.hpp"

namespace carillon::scene {

/// Reads the scene of a sound that is made outside of a build.
/// @param text       a configuration; its keys that belong to a build are not looked at
/// @param name       what messages call it
/// @param materials  of the object, which decide whether there is damping
/// @param place      what names them, for messages
/// @throws ConfigError
/// @throws InputError  it gives the strikes of a build, or a sample rate that is not whole
Scene read_strike_scene(const std::string& text, const std::string& name,
                        const std::vector<std::string>& overrides,
                        const std::vector<synth::material::Material>& materials,
                        const std::string& place);

/// One sound that is asked for outside of a build.
struct SingleStrike {
  KnownStrike known;       ///< what is not known is drawn
  std::uint64_t seed = 1;  ///< of everything that is drawn
  std::size_t repeat = 1;  ///< strikes one after the other on the same point
  double interval = 0;     ///< from one to the next [s]
};

/// A sound, and how it came about.
struct StruckSound {
  Sound sound;  ///< `object` and `record` are gone
  synth::modal::PointFrame struck;
  double impulse = 0;    ///< integral of the force [N s]
  std::string unit;      ///< of the sound before `gain`: m/s or Pa
  nlohmann::json drawn;  ///< what was drawn and found, by the names of a dataset's columns
  core::Trace trace;     ///< effects that ran
};

/// Strikes an object as a scene says.
/// @param shape  what it was solved as
/// @param cache  as SoundChain
/// @throws InputError  as effects do, or a known force where the scene has a striker or no contact
StruckSound strike_once(const Scene& scene, const std::string& shape, const SolvedObject& object,
                        const SingleStrike& strike, const std::filesystem::path& cache);

/// `modes, modes_above_nyquist, unit, sample_rate_hz, peak, position_m, normal, direction,
/// impulse_ns, contact_time_s`, every effect of the `scene`, the `effects` that ran and the
/// `record` of what was drawn.
nlohmann::json to_json(const StruckSound& struck, const Scene& scene);

}  // namespace carillon::scene
