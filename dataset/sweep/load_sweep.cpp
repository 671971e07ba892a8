#include "dataset/sweep/load_sweep.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "dataset/run/shared_meshes.hpp"
#include "mpi/comm.hpp"

namespace carillon::dataset::sweep {

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

/// Runs a step of loading a variant.
template <class Step>
auto in_variant(const Sweep& sweep, const SweepVariant& variant, const Step& step) {
  try {
    return step();
  } catch (const core::ConfigError& error) {
    refuse(sweep, variant, error);
  } catch (const core::InputError& error) {
    refuse(sweep, variant, error);
  }
}

run::LoadedBuild read_variant(const std::string& text, const run::BuildOptions& options,
                              const SweepVariant& variant) {
  run::BuildOptions own = options;
  // So that commands that are told to reproduce a failure speak of this variant alone.
  own.overrides.push_back("sweep=");
  own.overrides.insert(own.overrides.end(), variant.overrides.begin(), variant.overrides.end());
  return run::read_build(text, own);
}

}  // namespace

std::optional<LoadedSweep> load_sweep(const run::BuildOptions& options, MPI_Comm world) {
  const std::string text = run::shared_text(options, world);
  std::optional<LoadedSweep> loaded;
  mpi::agreed(world, [&] {
    std::optional<Sweep> sweep = read_sweep(text, options.config, options.overrides);
    if (!sweep) return;
    loaded.emplace();
    loaded->sweep = std::move(*sweep);
    for (const SweepVariant& variant : loaded->sweep.variants) {
      loaded->builds.push_back(
          in_variant(loaded->sweep, variant, [&] { return read_variant(text, options, variant); }));
    }
    loaded->name = loaded->builds.front().config.name;
  });
  if (!loaded) return loaded;
  const run::SharedMeshes meshes(loaded->builds, world);
  core::Sha256 fingerprints;
  mpi::agreed(world, [&] {
    for (std::size_t v = 0; v < loaded->builds.size(); ++v) {
      run::LoadedBuild& build = loaded->builds[v];
      build.plan = in_variant(loaded->sweep, loaded->sweep.variants[v], [&] {
        return plan::make_plan(build.config, meshes.of(build.config));
      });
      fingerprints.add(plan::fingerprint(build.config, build.plan));
    }
  });
  run::check_alike(fingerprints.hex(), world);
  return loaded;
}

}  // namespace carillon::dataset::sweep
