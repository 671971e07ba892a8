#include "synth/fit_cache.hpp"

#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "core/hash.hpp"

namespace carillon::synth {

namespace {

/// Changes with the method: older files are then never found.
constexpr const char* kMethod = "equivalent sources 2";

std::string key_of(const solvers::Modes& modes, std::span<const Listener> listeners,
                   const EquivalentSourcesOptions& options) {
  const std::vector<double> numbers = {options.per_wavelength,
                                       static_cast<double>(options.least),
                                       static_cast<double>(options.most),
                                       static_cast<double>(modes.surface.order),
                                       kAirDensity,
                                       kSoundSpeed};
  std::vector<double> places;
  for (const Vec3& node : modes.surface.nodes)
    places.insert(places.end(), node.begin(), node.end());
  for (const Listener& listener : listeners) {
    places.insert(places.end(), listener.position.begin(), listener.position.end());
  }
  // Lengths first, so that no list can pass for a part of its neighbour.
  const std::vector<std::uint64_t> lengths = {modes.surface.nodes.size(), listeners.size(),
                                              modes.surface.faces.size(), modes.size()};
  return core::Sha256()
      .add(kMethod)
      .add(std::span<const std::uint64_t>(lengths))
      .add(std::span<const double>(numbers))
      .add(std::span<const double>(places))
      .add(std::span<const std::int32_t>(modes.surface.faces))
      .add(std::span<const double>(modes.eigenvalues))
      .add(std::span<const float>(modes.shapes.data(),
                                  static_cast<std::size_t>(modes.shapes.size())))
      .hex();
}

/// The file: method, numbers of listeners, modes, sources and patches, delays, residuals,
/// decay rates, then pressures mode by mode; and the SHA-256 of it all.
std::string text_of(const EquivalentSourcesFit& fit) {
  std::string text = kMethod;
  const auto add = [&](const void* data, std::size_t bytes) {
    text.append(static_cast<const char*>(data), bytes);
  };
  const std::vector<std::uint64_t> counts = {fit.radiated.delays.size(), fit.residuals.size(),
                                             fit.sources, fit.patches};
  add(counts.data(), counts.size() * sizeof counts[0]);
  add(fit.radiated.delays.data(), fit.radiated.delays.size() * sizeof(double));
  add(fit.residuals.data(), fit.residuals.size() * sizeof(double));
  add(fit.decay_rates.data(), fit.decay_rates.size() * sizeof(double));
  add(fit.radiated.pressure.data(),
      static_cast<std::size_t>(fit.radiated.pressure.size()) * sizeof(std::complex<double>));
  return text + core::sha256(text);
}

std::optional<EquivalentSourcesFit> fit_of(const std::string& text, std::size_t listeners,
                                           std::size_t modes) {
  constexpr std::size_t kHash = 64;
  const std::size_t name = std::strlen(kMethod);
  const std::size_t size = name + 4 * sizeof(std::uint64_t) +
                           (listeners + 2 * modes + 2 * listeners * modes) * sizeof(double) + kHash;
  if (text.size() != size) return {};
  if (core::sha256(text.substr(0, size - kHash)) != text.substr(size - kHash)) return {};
  std::size_t at = name;
  const auto take = [&](void* data, std::size_t bytes) {
    if (bytes > 0) std::memcpy(data, text.data() + at, bytes);
    at += bytes;
  };
  std::uint64_t counts[4];
  take(counts, sizeof counts);
  if (counts[0] != listeners || counts[1] != modes) return {};
  EquivalentSourcesFit fit;
  fit.sources = counts[2];
  fit.patches = counts[3];
  fit.radiated.delays.resize(listeners);
  fit.residuals.resize(modes);
  fit.decay_rates.resize(modes);
  fit.radiated.pressure.resize(static_cast<Eigen::Index>(listeners),
                               static_cast<Eigen::Index>(modes));
  take(fit.radiated.delays.data(), listeners * sizeof(double));
  take(fit.residuals.data(), modes * sizeof(double));
  take(fit.decay_rates.data(), modes * sizeof(double));
  take(fit.radiated.pressure.data(), listeners * modes * sizeof(std::complex<double>));
  return fit;
}

}  // namespace

EquivalentSourcesFit cached_equivalent_sources(const solvers::Modes& modes,
                                               std::span<const Listener> listeners,
                                               const EquivalentSourcesOptions& options,
                                               const std::filesystem::path& folder) {
  if (folder.empty()) return fit_equivalent_sources(modes, listeners, options);
  const std::filesystem::path file = folder / (key_of(modes, listeners, options) + ".fit");
  std::error_code unreadable;
  if (std::filesystem::is_regular_file(file, unreadable)) {
    if (const auto fit = fit_of(core::read_file(file), listeners.size(), modes.size())) return *fit;
  }
  const EquivalentSourcesFit fit = fit_equivalent_sources(modes, listeners, options);
  core::write_text_durably(file, text_of(fit));
  return fit;
}

}  // namespace carillon::synth
