#pragma once

#include "core/hdf5.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::solvers::modes {

/// Stores modes in an HDF5 group (docs/format.md names the fields), with units as attributes.
void write_modes(const core::Hdf5Group& group, const Modes& modes);
Modes read_modes(const core::Hdf5Group& group);
/// The surface of a stored set alone.
ModeSurface read_mode_surface(const core::Hdf5Group& set);

}  // namespace carillon::solvers::modes
