#include "dataset/check/detail/column_rules.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <vector>

namespace carillon::dataset::check {

namespace {

std::vector<std::string> words_of(const std::string& text, char between = '|') {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, between);) words.push_back(word);
  return words;
}

core::Extent wanted_inner(const std::string& inner, const configuration::BuildConfig& config,
                          const core::Extent& found) {
  const std::uint64_t rows = config.scene.rows(), samples = config.scene.audio.samples();
  if (inner.empty()) return {};
  if (inner == "listeners") return {rows};
  core::Extent last = {samples};
  if (inner == "mel" && config.mel) {
    const synth::signal::MelExtent mel = synth::signal::mel_extent(samples, *config.mel);
    last = {static_cast<std::uint64_t>(mel.bands), static_cast<std::uint64_t>(mel.frames)};
  }
  if (inner != "audio" && inner != "mel") {
    core::Extent extent;
    const std::vector<std::string> words = words_of(inner, ',');
    for (std::size_t k = 0; k < words.size(); ++k) {
      const bool fixed = std::isdigit(static_cast<unsigned char>(words[k].front())) != 0;
      extent.push_back(fixed ? std::stoull(words[k]) : k < found.size() ? found[k] : 1);
    }
    return extent;
  }
  if (rows > 1) last.insert(last.begin(), rows);
  return last;
}

}  // namespace

std::optional<bool> expected(const core::ColumnRule& rule,
                             const configuration::BuildConfig& config) {
  std::string when = rule.when;
  if (when == "always") return true;
  if (when == "may") return {};
  if (when.starts_with("struck")) {  // objects that are struck, not simulations
    if (config.motion) return false;
    if (when == "struck") return true;
    when = when.substr(when.find(':') + 1);
  }
  const std::vector<std::string> effects = words_of(when);
  return std::any_of(effects.begin(), effects.end(),
                     [&](const std::string& effect) { return config.scene.runs(effect); });
}

std::string break_of(const core::ColumnRule& rule, const configuration::BuildConfig& config,
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
