#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "synth/modal/contact_force.hpp"

namespace carillon::synth::contact {

/// A force that is given in newtons over time, as a hammer records it: straight lines between its
/// samples, the first at t = 0. Where it does not begin or end at 0, it comes from there and goes
/// there within a sample more. For a strike of an impulse of 1 N s.
/// @param newtons  at equal steps
/// @throws InputError  no samples, more than 60 s of them, one that is not finite, none that is not
///                     0, or a sample rate that is not positive
modal::ContactForce recorded_force(std::span<const double> newtons, double sample_rate);

/// The same of a sound file of one channel.
/// @param peak  largest magnitude that the file is scaled to [N]; none: 1 N is full scale
/// @throws FileError   cannot be read
/// @throws InputError  several channels, a peak that is not positive, or as above; names the file
modal::ContactForce read_force(const std::filesystem::path& path, std::optional<double> peak);

}  // namespace carillon::synth::contact
