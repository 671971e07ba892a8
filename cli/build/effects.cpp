#include "cli/build/effects.hpp"

namespace carillon::cli {

namespace {

constexpr Effect all_effects[] = {
    {"damping", "Rayleigh damping of every mode", [](const BuildConfig&) { return true; },
     "every material has damping", ""},
    {"contact", "finite contact pulse of the striker",
     [](const BuildConfig& config) {
       if (config.strikes.given.empty()) return true;
       for (const GivenStrike& strike : config.strikes.given) {
         if (strike.contact_time > 0) return true;
       }
       return false;
     },
     "strikes.contact_time is not zero", "every given strike is an ideal impulse"},
    {"radiation", "sound pressure at listeners from the body's volume velocity (monopole)",
     [](const BuildConfig& config) { return !config.listeners.empty(); }, "listeners are placed",
     "no listener: the dry signal is the velocity of the struck point"},
    {"mel", "mel power spectrograms",
     [](const BuildConfig& config) { return config.mel.has_value(); },
     "the configuration has mel:", "the configuration has no mel:"},
    {"voxels", "voxel grid of each object",
     [](const BuildConfig& config) { return config.voxels.has_value(); },
     "the configuration has voxels:", "the configuration has no voxels:"},
    {"frames", "picture of each object",
     [](const BuildConfig& config) { return config.camera.has_value(); },
     "the configuration has camera:", "the configuration has no camera:"},
};

}  // namespace

std::span<const Effect> effects() {
  return all_effects;
}

nlohmann::json plan_effects(const BuildConfig& config) {
  nlohmann::json list = nlohmann::json::array();
  for (const Effect& effect : effects()) {
    const bool enabled = effect.wanted(config);
    list.push_back({{"name", effect.name},
                    {"enabled", enabled},
                    {"reason", enabled ? effect.reason_on : effect.reason_off}});
  }
  return list;
}

}  // namespace carillon::cli
