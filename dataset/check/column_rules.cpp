#include "dataset/check/column_rules.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>
#include <vector>

namespace carillon::dataset::check {

namespace {

constexpr ColumnRule rules[] = {
    {"audio", "", "audio", "m/s|Pa", "always"},
    {"mel", "float32", "mel", "power", "mel"},
    {"key", "text", "", "1", "always"},
    {"id", "uint64", "", "1", "always"},
    {"shape", "text", "", "1", "always"},
    {"family", "text", "", "1", "struck"},
    {"material", "text", "", "1", "always"},
    {"size", "float64", "", "1", "struck"},
    {"strike", "int64", "", "1", "struck"},
    {"split_shape", "text", "", "1", "always"},
    {"split_strike", "text", "", "1", "always"},
    {"position", "float64", "3", "m", "struck"},
    {"normal", "float64", "3", "1", "struck"},
    {"direction", "float64", "3", "1", "struck"},
    {"impulse", "float64", "", "N s", "struck"},
    {"contact_time", "float64", "", "s", "struck"},
    {"gain", "float64", "", "s/m|1/Pa", "always"},
    {"peak", "float64", "", "1", "always"},
    {"clipped", "int64", "", "1", "always"},
    {"modes", "int64", "", "1", "struck"},
    {"modes_above_nyquist", "int64", "", "1", "struck"},
    {"complete_to", "float64", "", "Hz", "struck"},
    {"pitch_error", "float64", "", "cent", "struck"},
    {"youngs_modulus", "float64", "", "Pa", "struck"},
    {"poisson_ratio", "float64", "", "1", "struck"},
    {"density", "float64", "", "kg/m^3", "struck"},
    {"damping_model", "text", "", "1", "struck"},
    {"alpha", "float64", "", "", "struck", true},
    {"negative_damping_modes", "int64", "", "1", "may"},
    {"negative_damping_low", "float64", "", "Hz", "may", true},
    {"negative_damping_high", "float64", "", "Hz", "may", true},
    {"striker", "text", "", "1", "striker"},
    {"striker_speed", "float64", "", "m/s", "striker"},
    {"striker_effective_mass", "float64", "", "kg", "striker"},
    {"striker_effective_radius", "float64", "", "m", "striker"},
    {"striker_peak_force", "float64", "", "N", "striker"},
    {"striker_hardness", "float64", "", "1", "striker"},
    {"striker_size", "float64", "", "1", "striker"},
    {"radiation_residual", "float64", "", "1", "may"},
    {"radiation_decay_rate", "float64", "", "1/s", "may"},
    {"radiation_doubtful_modes", "int64", "", "1", "may"},
    {"support_force", "float64", "*", "N", "supports"},
    {"support_position", "float64", "*,3", "m", "supports"},
    {"support_damping", "float64", "", "1/s", "supports"},
    {"support_index", "int64", "*", "1", "may"},
    {"support_coupled", "int64", "", "1", "may"},
    {"support_modes", "int64", "", "1", "may"},
    {"support_modes_compared", "int64", "", "1", "may"},
    {"support_decay_error", "float64", "", "1", "may", true},
    {"support_pitch_error", "float64", "", "cent", "may", true},
    {"support_decay_error_estimate", "float64", "", "1", "may", true},
    {"support_pitch_error_estimate", "float64", "", "cent", "may", true},
    {"thrift_modes_left_out", "int64", "", "1", "thrift"},
    {"thrift_error_bound", "float64", "", "dB", "thrift"},
    {"click_peak", "float64", "", "Pa", "struck:click"},
    {"click_left_out", "int64", "", "1", "struck:click"},
    {"take", "int64", "", "1", "motion"},
    {"bodies", "text", "", "1", "motion"},
    {"poses", "float64", "*,*,7", "m; w, x, y, z", "motion"},
    {"pose_step", "float64", "", "s", "motion"},
    {"energy", "float64", "*", "J", "motion"},
    {"left", "float64", "*", "s", "motion", true},
    {"start_overlap", "float64", "", "m", "motion"},
    {"substeps", "int64", "", "1", "motion"},
    {"too_fast_at", "float64", "", "s", "motion", true},
    {"strikes", "int64", "", "1", "motion"},
    {"strike_time", "float64", "*", "s", "motion", true},
    {"strike_bodies", "int64", "*,2", "1", "motion"},
    {"strike_point", "float64", "*,3", "m", "motion", true},
    {"strike_normal", "float64", "*,3", "1", "motion", true},
    {"strike_impulse", "float64", "*,3", "N s", "motion", true},
    {"strike_speed", "float64", "*", "m/s", "motion", true},
    {"strike_duration", "float64", "*", "s", "motion", true},
    {"lasting_contacts", "int64", "", "1", "motion"},
    {"touch", "float64", "*,3", "N", "touch"},
    {"touch_tip", "float64", "*,3", "m", "touch"},
    {"touch_hand", "float64", "*,3", "m", "touch"},
    {"touch_rate", "float64", "", "Hz", "touch"},
    {"touch_limited", "int64", "", "1", "touch"},
    {"touch_held_back", "int64", "", "1", "touch"},
    {"frames", "uint8", "*,*,*,3", "sRGB", "movie"},
    {"depth", "float32", "*,*,*", "m", "may"},
    {"masks", "uint8", "*,*,*", "1", "may"},
    {"frame_rate", "float64", "", "Hz", "movie"},
    {"room", "int64", "", "1", "room|tail"},
    {"room_size", "float64", "3", "m", "room|tail"},
    {"room_source", "float64", "3", "m", "room|tail"},
    {"room_rt60", "float64", "8", "s", "room|tail"},
    {"tail_level", "float64", "listeners", "dB", "tail"},
    {"tail_join", "float64", "listeners", "dB", "tail"},
    {"noise_ratio", "float64", "", "dB", "noise", true},
    {"noise_level", "float64", "", "m/s|Pa", "noise"},
    {"noise_source", "text", "", "1", "noise"},
    {"active_begin", "float64", "", "s", "noise"},
    {"active_end", "float64", "", "s", "noise"},
    {"recording_shift", "float64", "", "s", "may"},
    {"recording_gain", "float64", "", "dB", "recording"},
    {"recording_clipped", "int64", "", "1", "recording"},
    {"recording_bits", "int64", "", "1", "recording"},
    {"recording_silent", "int64", "", "1", "recording"},
};

std::vector<std::string> words_of(const std::string& text, char between = '|') {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, between);) words.push_back(word);
  return words;
}

bool is_alpha(const std::string& column) {
  return column.size() > 5 && column.starts_with("alpha") &&
         std::all_of(column.begin() + 5, column.end(), [](char c) { return c >= '0' && c <= '9'; });
}

core::Extent wanted_inner(const std::string& inner, const configuration::BuildConfig& config,
                          const core::Extent& found) {
  const std::uint64_t rows = config.scene.rows(), samples = config.scene.audio.samples();
  if (inner.empty()) return {};
  if (inner == "listeners") return {rows};
  core::Extent last = {samples};
  if (inner == "mel" && config.mel) {
    last = {static_cast<std::uint64_t>(config.mel->bands),
            static_cast<std::uint64_t>(synth::signal::mel_frames(samples, *config.mel))};
  }
  if (inner != "audio" && inner != "mel") {
    core::Extent extent;
    const std::vector<std::string> words = words_of(inner, ',');
    for (std::size_t k = 0; k < words.size(); ++k) {
      const bool any = words[k] == "*";
      extent.push_back(!any ? std::stoull(words[k]) : k < found.size() ? found[k] : 1);
    }
    return extent;
  }
  if (rows > 1) last.insert(last.begin(), rows);
  return last;
}

}  // namespace

std::span<const ColumnRule> column_rules() {
  return rules;
}

const ColumnRule* find_rule(const std::string& column) {
  const std::string name = is_alpha(column) ? "alpha" : column;
  for (const ColumnRule& rule : rules) {
    if (name == rule.name) return &rule;
  }
  return nullptr;
}

std::optional<bool> expected(const ColumnRule& rule, const configuration::BuildConfig& config) {
  std::string when = rule.when;
  if (when == "always") return true;
  if (when == "may") return {};
  if (when.starts_with("struck")) {  // bodies that are struck, not takes
    if (config.motion) return false;
    if (when == "struck") return true;
    when = when.substr(when.find(':') + 1);
  }
  const std::vector<std::string> effects = words_of(when);
  return std::any_of(effects.begin(), effects.end(),
                     [&](const std::string& effect) { return config.scene.runs(effect); });
}

std::string break_of(const ColumnRule& rule, const configuration::BuildConfig& config,
                     const std::string& type, const core::Extent& inner, const std::string& unit) {
  const bool int16 = config.scene.audio.dtype == core::SampleFormat::int16;
  const std::string wanted = *rule.type != '\0' ? rule.type : int16 ? "int16" : "float32";
  if (type != wanted) return fmt::format("holds {}, not {}", type, wanted);
  const core::Extent extent = wanted_inner(rule.inner, config, inner);
  if (inner != extent) {
    return fmt::format("a row is [{}], not [{}]", fmt::join(inner, ", "), fmt::join(extent, ", "));
  }
  const std::vector<std::string> units = words_of(rule.units);
  if (!units.empty() && std::find(units.begin(), units.end(), unit) == units.end()) {
    return fmt::format("is in \"{}\", not {}", unit, fmt::join(units, " or "));
  }
  return "";
}

}  // namespace carillon::dataset::check
