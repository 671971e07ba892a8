#pragma once

#include <string>

#include "scene/solved_object.hpp"

namespace carillon::scene {

/// Whether a glTF file has a modal model of the extension KHR_audio_rigid_bodies. False as well
/// where it cannot be read.
bool has_modal_model(const std::string& path);

/// An object that comes with its modes: those of a node that has a modal model
/// (KHR_audio_rigid_bodies, draft of 2026). Nothing is solved.
///
/// The sample points are the surface, with the file's triangles between them; they stand with z up,
/// by the node's transform. Its scale, which has to be uniform, makes frequencies and shapes those
/// of a body of that size (Zheng and James 2010, appendix E), and decay rates those of the
/// material's alpha and beta where it has both. Decay rates are the file's own, whatever its
/// material says. Of the certificate nothing is known: no residuals, no band. Constants of the
/// material that the file does not say are assumed, with a warning.
/// @param node  its name; "": the only one
/// @throws InputError  no such model, several and no name, numbers that do not fit together
/// @throws FileError   cannot be read
SolvedObject read_sounding_gltf(const std::string& path, const std::string& node);

}  // namespace carillon::scene
