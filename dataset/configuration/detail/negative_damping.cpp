#include "dataset/configuration/detail/negative_damping.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "synth/damping/damping.hpp"

namespace carillon::dataset::configuration {

namespace {

/// Bands may begin at 0 Hz, logarithmic steps cannot.
double lowest(const solvers::modes::Band& band) {
  return std::max(band.min_frequency, std::min(1.0, band.max_frequency / 1000));
}

std::string what_becomes(const std::string& choice) {
  if (choice == "clamp") return "modes there will be undamped";
  if (choice == "drop") return "modes there will be left out";
  return "a mode there will fail its object";
}

}  // namespace

std::string negative_damping(std::span<const synth::material::Material> materials,
                             const solvers::modes::Band& band, const std::string& choice) {
  std::vector<std::string> found;
  for (const synth::material::Material& material : materials) {
    std::vector<std::string> ranges;
    for (const synth::damping::NegativeRange& range :
         synth::damping::negative_ranges(material.damping, lowest(band), band.max_frequency)) {
      ranges.push_back(fmt::format("{:.5g} to {:.5g} Hz", range.low, range.high));
    }
    if (!ranges.empty()) {
      found.push_back(fmt::format("{} from {}", material.name, fmt::join(ranges, " and ")));
    }
  }
  if (found.empty()) return "";
  return fmt::format("negative: {}; {} (negative_damping: {})", fmt::join(found, ", "),
                     what_becomes(choice), choice);
}

}  // namespace carillon::dataset::configuration
