#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "dataset/exporters/gltf_surface.hpp"
#include "synth/material/material.hpp"
#include "synth/surface/rigid_body.hpp"

namespace carillon::dataset::exporters {

/// A modal model as the glTF extension KHR_audio_rigid_bodies has it (draft of 2026), in glTF's
/// axes.
struct GltfAudio {
  std::vector<float> frequencies;      ///< damped [Hz], n values, the loudest modes first
  std::vector<float> decay_rates;      ///< d, amplitudes fall as exp(-d t) [1/s], n values
  GltfVectors positions;               ///< of the sample points [m], p values
  GltfVectors shapes;                  ///< mass-normalised [kg^-1/2], n x p values, mode by mode
  std::vector<std::uint32_t> indices;  ///< triangles between the sample points
  nlohmann::ordered_json material;     ///< an acousticMaterial; null where there are several
  nlohmann::ordered_json mass_properties;  ///< of the body, in kg, m and kg m^2
};

/// Where mode shapes are sampled.
enum class AudioPoints {
  corners,  ///< at the corners of the surface's faces
  nodes     ///< at all of its nodes, as finely as they were solved
};

/// The modes of an object that ring: those that are overdamped are left out. They are ordered by
/// the energy that a strike anywhere on the surface leaves far away: the mean square of a shape,
/// times that of its normal part, times (omega F)^2 / d, where F = 1 / (1 + (2 f tau)^2) is about
/// the spectrum of a contact of tau = 0.5 ms.
/// @param decay_rates  of every mode [1/s]
/// @param materials    one for each region; Rayleigh's parameters of the only one are written as
/// alpha
///                     and beta
/// @param rigid        of the body, in our axes
/// @throws InputError  no mode rings
GltfAudio gltf_audio(const solvers::modes::Modes& modes, std::span<const double> decay_rates,
                     std::span<const synth::material::Material> materials,
                     const synth::surface::RigidBody& rigid, AudioPoints points);

}  // namespace carillon::dataset::exporters
