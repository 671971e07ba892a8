#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/image.hpp"
#include "render/looks/appearance.hpp"
#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::render {

using looks::Appearance;
using looks::appearance_of;
using looks::FaceLooks;

/// What pictures are drawn with, off screen: "osmesa" or "egl"; "none" in a build with
/// -DCARILLON_RENDER=OFF, where whatever draws throws an Error that says so.
std::string_view offscreen();

inline constexpr int max_picture_side = 4096;  ///< [pixel]

/// @throws InputError  a side or a view that no picture has; [pixel], [rad]
void check_picture(int width, int height, double field_of_view);

/// Where the picture is taken from; z is up, azimuth 0 looks from +x, a quarter turn from +y.
struct Camera {
  int width = 256;  ///< [pixel]
  int height = 256;
  double azimuth = 0.6;        ///< [rad] about the vertical z axis
  double elevation = 0.45;     ///< [rad] above the horizon
  double field_of_view = 0.6;  ///< vertical [rad]
  double distance = 0;         ///< [m] from the body's centre; 0: the body fills the frame
};

/// Picture of a body before a light grey backdrop, lit by a key, a fill and a rim light that stay
/// with the camera, with shadows of its own, drawn off screen (Cook-Torrance shading,
/// GGX). Three channels, sRGB, nine samples a pixel averaged in linear light. Faces that meet at
/// more than 40 degrees keep their edge, others are shaded smoothly. The same input gives the same
/// bytes. The OpenGL context is made at the first picture of each thread and kept.
/// @throws InputError   no faces or extent, a camera or appearance out of range, colours that are
///                      not as many as vertices, or looks of faces that are not as many as these
/// @throws core::Error  no OpenGL 3.3 context can be made
core::Image render_frame(const solvers::mesh::SurfaceMesh& mesh, const Camera& camera,
                         const Appearance& appearance, const FaceLooks& faces = {});
/// The same from several places, one picture for each.
std::vector<core::Image> render_frames(const solvers::mesh::SurfaceMesh& mesh,
                                       std::span<const Camera> cameras,
                                       const Appearance& appearance, const FaceLooks& faces = {});

}  // namespace carillon::render
