#pragma once

#include <filesystem>
#include <span>

#include "synth/equivalent_sources.hpp"

namespace carillon::synth {

/// fit_equivalent_sources(), kept in a file under the hash of all it depends on: surface, shapes,
/// eigenvalues, listeners and options. A file that is not whole is computed again.
/// @param folder  made when it is missing; empty: nothing is kept
/// @throws InputError  as fit_equivalent_sources()
/// @throws FileError   the folder cannot be written
EquivalentSourcesFit cached_equivalent_sources(const solvers::Modes& modes,
                                               std::span<const Listener> listeners,
                                               const EquivalentSourcesOptions& options,
                                               const std::filesystem::path& folder);

}  // namespace carillon::synth
