#include "eval/features/feature_json.hpp"

#include "core/json.hpp"

namespace carillon::eval::features {

nlohmann::json to_json(const FeatureSet& set) {
  nlohmann::json features = nlohmann::json::array(), hums = nlohmann::json::array();
  for (const Feature& f : set.features) {
    features.push_back({{"frequency_hz", f.frequency},
                        {"decay_rate_per_s", f.decay_rate},
                        {"amplitude", f.amplitude},
                        {"phase_rad", core::number_or_null(f.phase)},
                        {"frequency_error_hz", core::number_or_null(f.frequency_error)},
                        {"decay_rate_error_per_s", core::number_or_null(f.decay_rate_error)},
                        {"amplitude_error", core::number_or_null(f.amplitude_error)},
                        {"snr_db", core::number_or_null(f.snr)},
                        {"reverberant", f.reverberant},
                        {"channel", f.channel + 1}});
  }
  for (const Hum& hum : set.hums) {
    hums.push_back({{"frequency_hz", hum.frequency},
                    {"decay_rate_per_s", hum.decay_rate},
                    {"amplitude", hum.amplitude}});
  }
  return {{"sample_rate_hz", set.sample_rate},
          {"onset_s", set.onset},
          {"begin_s", set.begin},
          {"end_s", set.end},
          {"clipped_samples", set.clipped},
          {"energy_explained", set.explained},
          {"features", features},
          {"hums", hums},
          {"remarks", set.remarks},
          {"nothing", set.nothing}};
}

}  // namespace carillon::eval::features
