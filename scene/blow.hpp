#pragma once

#include <cstddef>
#include <vector>

#include "core/random.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon::scene {

/// What a blow on one body is where the command line says nothing else.
inline constexpr const char* default_impulse = "0.02 N s";
inline constexpr const char* default_contact_time = "0.2 ms";

/// Points far from each other: the first is drawn by area, each next one is the farthest from all
/// before it (Gonzalez 1985) of 64 drawn for each point that is wanted.
std::vector<synth::modal::SurfacePoint> spread_points(const synth::modal::SurfaceSampler& sampler,
                                                      const solvers::modes::ModeSurface& surface,
                                                      std::size_t count,
                                                      core::RandomStream& places);

}  // namespace carillon::scene
