#pragma once

#include <span>

#include "render/scene_frame.hpp"

namespace carillon::render {

/// @throws InputError  what SceneRenderer says
void check(const Scene& scene);
void check(const SceneCamera& camera, const Vec3& light);
void check_poses(std::span<const ScenePose> poses, std::size_t bodies);

}  // namespace carillon::render
