#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "scene/object.hpp"
#include "scene/scene.hpp"

namespace carillon::eval::accuracy {

/// How much of an object and a room a sound needs: levels with fewer modes or fewer reflections
/// against the sound with all of them.
struct SoundStudy {
  std::string name, material;  ///< of the object, as configured
  scene::ObjectRequest object;
  int strikes = 5;
  std::vector<int> mode_counts;        ///< lowest so many, ascending
  std::vector<int> image_orders;       ///< ascending; the last is the reference
  scene::Scene without_room;           ///< in which fewer modes ring
  std::vector<scene::Scene> of_order;  ///< one for each of image_orders
};

/// Reads `sound:` of a study's configuration.
/// @param materials  of the object, if it names none
/// @param reread  the same configuration with further overrides
/// @throws ConfigError
SoundStudy read_sound_study(
    core::ConfigNode node, const std::vector<std::string>& materials, const std::string& file_name,
    const std::function<core::ConfigNode(const std::vector<std::string>&)>& reread);

/// What came of it.
struct SoundFindings {
  std::string failure{};  ///< why there is nothing else, else ""
  std::string object{}, material{};
  std::size_t modes = 0;
  double prepare_s = 0;  ///< of the object's radiation [s]
  struct RefinementLevel {
    std::string key;  ///< `modes` or `image order`
    int value = 0;
    std::size_t sounds = 0;
    double seconds = 0, error_db = 0;  ///< medians; NaN where all is silent
  };
  std::vector<RefinementLevel> levels{};
};

nlohmann::ordered_json to_json(const SoundFindings& findings);
/// A table for a person.
void print(const SoundFindings& findings);

/// Runs it on this rank, whose communicator `alone` is. The sounds' difference is the mean of the
/// magnitudes of the logarithms of the ratios of short-time spectra
/// (perception::SpectralDistance::log_magnitude) in dB, of sounds whose reference has a peak of 1;
/// time that of making the sound from known modes, processor time.
SoundFindings measure_sounds(const SoundStudy& study, MPI_Comm alone,
                             const std::filesystem::path& cache);

}  // namespace carillon::eval::accuracy
