#include "cli/sweep/load_sweep.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

namespace {

/// Where a variant's message points at an override, the value in the file is meant.
[[noreturn]] void refuse(const Sweep& sweep, const SweepVariant& variant,
                         const core::Error& error) {
  std::string message = error.message();
  for (const std::string& assignment : variant.overrides) {
    const std::string origin = "--set " + assignment + ": ";
    if (!message.starts_with(origin)) continue;
    message = fmt::format("{}: {}", sweep.places.at(assignment), message.substr(origin.size()));
  }
  throw core::ConfigError(fmt::format("{} (sweep, variant {})", message, variant.folder),
                          error.hint());
}

LoadedBuild expand_variant(const std::string& text, const BuildOptions& options, const Sweep& sweep,
                           const SweepVariant& variant) {
  BuildOptions own = options;
  // So that commands that are told to reproduce a failure speak of this variant alone.
  own.overrides.push_back("sweep=");
  own.overrides.insert(own.overrides.end(), variant.overrides.begin(), variant.overrides.end());
  try {
    return expand(text, own);
  } catch (const core::ConfigError& error) {
    refuse(sweep, variant, error);
  } catch (const core::InputError& error) {
    refuse(sweep, variant, error);
  }
}

}  // namespace

std::optional<LoadedSweep> load_sweep(const BuildOptions& options, MPI_Comm world) {
  const std::string text = shared_text(options.config, world);
  std::optional<LoadedSweep> loaded;
  core::Sha256 fingerprints;
  mpi::agreed(world, [&] {
    std::optional<Sweep> sweep = read_sweep(text, options.config, options.overrides);
    if (!sweep) return;
    loaded.emplace();
    loaded->sweep = std::move(*sweep);
    for (const SweepVariant& variant : loaded->sweep.variants) {
      loaded->builds.push_back(expand_variant(text, options, loaded->sweep, variant));
      const LoadedBuild& build = loaded->builds.back();
      fingerprints.add(fingerprint(build.config, build.plan));
    }
    loaded->name = loaded->builds.front().config.name;
  });
  if (loaded) check_alike(fingerprints.hex(), world);
  return loaded;
}

}  // namespace carillon::cli
