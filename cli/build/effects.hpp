#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "cli/build/configuration.hpp"

namespace carillon::cli {

/// A part of the physics or of the output that only runs when a scene calls for it.
struct Effect {
  const char* name;
  const char* description;
  bool (*wanted)(const BuildConfig& config);
  const char* reason_on;   ///< what asks for it
  const char* reason_off;  ///< why it is not needed
};

/// All effects, in the order they act.
std::span<const Effect> effects();

/// `effects[].name, .enabled, .reason` of a configuration.
nlohmann::json plan_effects(const BuildConfig& config);

}  // namespace carillon::cli
