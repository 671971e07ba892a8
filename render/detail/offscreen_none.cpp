#include "core/error.hpp"
#include "render/frame.hpp"
#include "render/scene_frame.hpp"

namespace carillon::render {

namespace {

[[noreturn]] void refuse() {
  throw core::Error("this program was built without pictures", "build with -DCARILLON_RENDER=ON");
}

}  // namespace

struct SceneRenderer::Parts {};

std::string_view offscreen() {
  return "none";
}

core::Image render_frame(const solvers::mesh::SurfaceMesh& /*mesh*/, const Camera& /*camera*/,
                         const Appearance& /*appearance*/, const FaceLooks& /*faces*/) {
  refuse();
}

std::vector<core::Image> render_frames(const solvers::mesh::SurfaceMesh& /*mesh*/,
                                       std::span<const Camera> /*cameras*/,
                                       const Appearance& /*appearance*/,
                                       const FaceLooks& /*faces*/) {
  refuse();
}

SceneRenderer::SceneRenderer(const Scene& /*scene*/) {
  refuse();
}

SceneRenderer::~SceneRenderer() = default;
SceneRenderer::SceneRenderer(SceneRenderer&&) noexcept = default;

void SceneRenderer::look_from(const SceneCamera& /*camera*/, const Vec3& /*light*/) {
  refuse();
}

SceneFrame SceneRenderer::draw(std::span<const ScenePose> /*poses*/) {
  refuse();
}

}  // namespace carillon::render
