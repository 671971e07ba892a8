#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "scene/body.hpp"
#include "scene/scene.hpp"

namespace carillon::eval::accuracy {

/// How much of a body and a room a sound needs: levels with fewer modes or fewer reflections
/// against the sound with all of them.
struct SoundStudy {
  std::string name, material;  ///< of the body, as configured
  scene::BodyRequest body;
  int strikes = 5;
  std::vector<int> modes;              ///< lowest so many, ascending
  std::vector<int> image_orders;       ///< ascending; the last is the reference
  scene::Scene without_room;           ///< in which fewer modes ring
  std::vector<scene::Scene> of_order;  ///< one for each of image_orders
};

/// Reads `sound:` of a study's configuration.
/// @param reread  the same configuration with further overrides
/// @throws ConfigError
SoundStudy read_sound_study(
    core::ConfigNode node, const std::string& file_name,
    const std::function<core::ConfigNode(const std::vector<std::string>&)>& reread);

/// Runs it on this rank, whose communicator `alone` is. The sounds' difference is the mean of the
/// magnitudes of the logarithms of the ratios of short-time spectra
/// (perception::SpectralDistance::log_magnitude) in dB, of sounds whose reference has a peak of 1;
/// time that of making the sound from known modes, processor time.
/// @return `body`, `material`, `modes`, `prepare_s` (the body's radiation) and `levels[]`: `key`
///         (`modes` or `image order`), `value`, `sounds`, `seconds` and `error_db` (medians)
nlohmann::ordered_json measure_sounds(const SoundStudy& study, MPI_Comm alone,
                                      const std::filesystem::path& cache);

}  // namespace carillon::eval::accuracy
