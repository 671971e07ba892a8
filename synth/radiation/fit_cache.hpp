#pragma once

#include <filesystem>

#include "synth/radiation/equivalent_sources.hpp"

namespace carillon::synth::radiation {

/// fit_equivalent_sources(), kept in a file under the hash of all it depends on: surface, shapes,
/// eigenvalues and options. Listeners are no part of it. A file that is not whole is computed
/// again.
/// @param folder  made when it is missing; empty, or not to be written to: nothing is kept
/// @throws InputError  as fit_equivalent_sources()
EquivalentSources cached_equivalent_sources(const solvers::modes::Modes& modes,
                                            const EquivalentSourcesOptions& options,
                                            const std::filesystem::path& folder);

}  // namespace carillon::synth::radiation
