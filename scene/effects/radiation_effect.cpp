#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <memory>

#include "scene/effects/detail/list.hpp"
#include "scene/effects/detail/radiation_model.hpp"
#include "scene/scene.hpp"
#include "synth/radiation/fit_cache.hpp"
#include "synth/radiation/rayleigh_integral.hpp"

namespace carillon::scene {

namespace {

struct RadiationConfig {
  std::string model;
  std::string doubtful;
  bool damping = true;  ///< what is radiated is lost to the object
  synth::radiation::EquivalentSourcesOptions sources;
};

/// What an object's fit came to, recorded with each of its sounds.
struct FitFindings {
  double largest_residual = 0;
  double largest_decay_rate = 0;  ///< by radiation, of a mode [1/s]
  std::int64_t doubtful_modes = 0;
};

/// Estimated seconds for the fit of one object (docs/sound/radiation.md).
constexpr double seconds_per_fit = 2;

FitFindings radiate(const RadiationConfig& config, const std::filesystem::path& cache,
                    RingingObject& object) {
  FitFindings findings;
  synth::radiation::EquivalentSources fit =
      synth::radiation::cached_equivalent_sources(*object.modes, config.sources, cache);
  for (std::size_t mode = 0; mode < fit.residuals.size(); ++mode) {
    findings.largest_residual = std::max(findings.largest_residual, fit.residuals[mode]);
    if (fit.residuals[mode] <= synth::radiation::residual_limit) continue;
    ++findings.doubtful_modes;
    if (config.doubtful == "drop") {
      fit.amplitudes.col(static_cast<Eigen::Index>(mode)).setZero();
    }
  }
  if (findings.doubtful_modes > 0) {
    const std::string message = fmt::format(
        "{}: equivalent sources leave more than {:.0f} % of the normal velocity of {} of {} modes "
        "(worst {:.0f} %)",
        object.id, 100 * synth::radiation::residual_limit, findings.doubtful_modes,
        fit.residuals.size(), 100 * findings.largest_residual);
    if (config.doubtful == "stop") {
      throw core::InputError(message, "raise radiation.max_sources or lower modes.max_frequency");
    }
    spdlog::warn("{}: {}", message, config.doubtful == "drop" ? "silenced" : "used as they are");
  }
  for (std::size_t mode = 0; config.damping && mode < fit.decay_rates.size(); ++mode) {
    findings.largest_decay_rate = std::max(findings.largest_decay_rate, fit.decay_rates[mode]);
    object.decay_rates[mode] += fit.decay_rates[mode];
  }
  object.field = std::make_shared<const synth::radiation::SourceField>(std::move(fit));
  object.pressure = synth::radiation::pressure_readout(object.field->pressure_at(object.listeners),
                                                       *object.modes, object.decay_rates);
  return findings;
}

EffectParts start(const RadiationConfig& config, const std::filesystem::path& cache) {
  EffectParts parts;
  if (config.model == "monopole") {
    parts.object = [](RingingObject& object) {
      object.pressure = synth::modal::monopole(*object.modes, object.listeners);
    };
  } else if (config.model == "rayleigh_integral") {
    parts.object = [](RingingObject& object) {
      object.pressure = synth::radiation::pressure_readout(
          synth::radiation::rayleigh_pressure(*object.modes, object.listeners), *object.modes,
          object.decay_rates);
    };
  } else {
    const auto found = std::make_shared<std::map<std::string, FitFindings>>();
    const std::filesystem::path folder = cache.empty() ? cache : cache / "radiation";
    parts.object = [=](RingingObject& object) {
      (*found)[object.id] = radiate(config, folder, object);
    };
    parts.rings = [=](Sound& sound) {
      if (sound.record == nullptr) return;
      const FitFindings& findings = found->at(sound.object->id);
      sound.record->add("radiation_residual", findings.largest_residual);
      sound.record->add("radiation_doubtful_modes", findings.doubtful_modes);
      sound.record->add("radiation_decay_rate", findings.largest_decay_rate);
    };
  }
  return parts;
}

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  core::ConfigNode node = root.child("radiation");
  RadiationConfig config;
  config.model = read_radiation_model(node);
  if (config.model == "equivalent_sources") {
    config.damping = node.flag("damps_modes", true);
    config.doubtful = node.choice("doubtful", {"keep", "drop", "stop"}, "keep");
    config.sources.per_wavelength = static_cast<double>(node.integer("per_wavelength", 1, 100, 4));
    config.sources.min_sources = static_cast<int>(node.integer("min_sources", 10, 5000, 200));
    config.sources.max_sources =
        static_cast<int>(node.integer("max_sources", config.sources.min_sources, 5000,
                                      std::max(400, config.sources.min_sources)));
  }
  SceneEffect effect;
  if (scene.listeners.empty()) {
    effect.reason_off = "no listener: the dry signal is the velocity of the struck point";
  } else if (config.model == "off") {
    effect.reason_off = "radiation.model: off (" + node.where("model") + ")";
  } else {
    effect.asked_by = "listeners: (" + root.where("listeners") + ")";
  }
  // A fit serves all sounds and listeners of its object.
  if (config.model == "equivalent_sources") effect.seconds_per_object = seconds_per_fit;
  effect.start = [config](const std::filesystem::path& cache) { return start(config, cache); };
  return effect;
}

}  // namespace

const Effect radiation_effect = {.name = "radiation",
                                 .description = "sound pressure at listeners",
                                 .key = "radiation",
                                 .stage = "object",
                                 .read = read};

}  // namespace carillon::scene
