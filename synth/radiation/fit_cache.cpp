#include "synth/radiation/fit_cache.hpp"

#include <cstring>
#include <string>
#include <vector>

#include "core/cached.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"

namespace carillon::synth::radiation {

namespace {

/// Changes with the method: older files are then never found.
constexpr const char* method = "equivalent sources 4";

std::string key_of(const solvers::modes::Modes& modes, const EquivalentSourcesOptions& options) {
  const std::vector<double> numbers = {options.per_wavelength,
                                       static_cast<double>(options.min_sources),
                                       static_cast<double>(options.max_sources),
                                       static_cast<double>(modes.surface.order),
                                       modal::air_density,
                                       modal::speed_of_sound};
  std::vector<double> places;
  for (const Vec3& node : modes.surface.nodes)
    places.insert(places.end(), node.begin(), node.end());
  // Lengths first, so that no list can pass for a part of its neighbour.
  const std::vector<std::uint64_t> lengths = {modes.surface.nodes.size(),
                                              modes.surface.faces.size(), modes.size()};
  const solvers::modes::ModeShapes::Rows shapes = modes.shapes.at_nodes();
  return core::Sha256()
      .add(method)
      .add(std::span<const std::uint64_t>(lengths))
      .add(std::span<const double>(numbers))
      .add(std::span<const double>(places))
      .add(std::span<const std::int32_t>(modes.surface.faces))
      .add(std::span<const double>(modes.eigenvalues))
      .add(std::span<const float>(shapes.data(), static_cast<std::size_t>(shapes.size())))
      .hex();
}

/// Calls `each` with every list of numbers of a fit and its length, in the order of the file.
template <class Fit, class Each>
void for_each_list(Fit& fit, const Each& each) {
  each(fit.residuals.data(), fit.residuals.size());
  each(fit.decay_rates.data(), fit.decay_rates.size());
  each(fit.wavenumbers.data(), fit.wavenumbers.size());
  each(fit.centroid.data(), std::size_t{3});
  each(&fit.size, std::size_t{1});
  each(&fit.nearest, std::size_t{1});
  each(fit.points.data(), fit.points.size());
  each(fit.directions.data(), fit.directions.size());
  each(fit.strengths.outerIndexPtr(), static_cast<std::size_t>(fit.strengths.outerSize() + 1));
  each(fit.strengths.innerIndexPtr(), static_cast<std::size_t>(fit.strengths.nonZeros()));
  each(fit.strengths.valuePtr(), static_cast<std::size_t>(fit.strengths.nonZeros()));
  each(fit.amplitudes.data(), static_cast<std::size_t>(fit.amplitudes.size()));
  each(fit.outline.vertices.data(), fit.outline.vertices.size());
  each(fit.outline.triangles.data(), fit.outline.triangles.size());
}

/// Lengths of a fit's lists.
struct Counts {
  std::uint64_t modes, layers, patches, points, entries, vertices, triangles;
};

Counts counts_of(const EquivalentSources& fit) {
  return {fit.modes(),
          fit.layers,
          fit.patches,
          fit.points.size(),
          static_cast<std::uint64_t>(fit.strengths.nonZeros()),
          fit.outline.vertices.size(),
          fit.outline.triangles.size()};
}

EquivalentSources empty_fit(const Counts& counts) {
  EquivalentSources fit;
  const auto layers = static_cast<Eigen::Index>(counts.layers);
  fit.layers = counts.layers;
  fit.patches = counts.patches;
  fit.residuals.resize(counts.modes);
  fit.decay_rates.resize(counts.modes);
  fit.wavenumbers.resize(counts.modes);
  fit.points.resize(counts.points);
  fit.directions.resize(counts.points);
  fit.strengths.resize(static_cast<Eigen::Index>(counts.points), layers);
  fit.strengths.resizeNonZeros(static_cast<Eigen::Index>(counts.entries));
  // The number of entries is the last of the outer indices, until they are read.
  fit.strengths.outerIndexPtr()[counts.points] = static_cast<int>(counts.entries);
  fit.amplitudes.resize(layers, static_cast<Eigen::Index>(counts.modes));
  fit.outline.vertices.resize(counts.vertices);
  fit.outline.triangles.resize(counts.triangles);
  return fit;
}

/// The file: method, counts and lists, and the SHA-256 of it all.
std::string text_of(const EquivalentSources& fit) {
  std::string text = method;
  const auto add = [&](const auto* values, std::size_t count) {
    text.append(reinterpret_cast<const char*>(values), count * sizeof *values);
  };
  const Counts counts = counts_of(fit);
  add(&counts, 1);
  for_each_list(fit, add);
  return text + core::sha256(text);
}

/// @throws FileError  not what text_of() made of a fit of so many modes
EquivalentSources fit_of(const std::string& text, std::size_t modes) {
  constexpr std::size_t hash = 64;
  const std::size_t name = std::strlen(method);
  if (text.size() < name + sizeof(Counts) + hash) throw core::FileError("cut short");
  const std::size_t end = text.size() - hash;
  // With the right hash it is what was written, and its counts can be believed.
  if (core::sha256(text.substr(0, end)) != text.substr(end)) {
    throw core::FileError("cut short or changed");
  }
  std::size_t at = name;
  const auto take = [&](auto* values, std::size_t count) {
    const std::size_t bytes = count * sizeof *values;
    if (bytes > 0) std::memcpy(static_cast<void*>(values), text.data() + at, bytes);
    at += bytes;
  };
  Counts counts;
  take(&counts, 1);
  if (counts.modes != modes) throw core::FileError("a fit of other modes");
  EquivalentSources fit = empty_fit(counts);
  for_each_list(fit, take);
  return fit;
}

}  // namespace

EquivalentSources cached_equivalent_sources(const solvers::modes::Modes& modes,
                                            const EquivalentSourcesOptions& options,
                                            const std::filesystem::path& folder) {
  if (folder.empty()) return fit_equivalent_sources(modes, options);
  return core::cached<EquivalentSources>(
      folder, key_of(modes, options) + ".fit",
      [&](const auto& path) { return fit_of(core::read_file(path), modes.size()); },
      [](const auto& path, const EquivalentSources& fit) {
        core::write_text_durably(path, text_of(fit));
      },
      [&] { return fit_equivalent_sources(modes, options); });
}

}  // namespace carillon::synth::radiation
