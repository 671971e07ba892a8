#include "dataset/samples/detail/simulation_parts.hpp"

#include <algorithm>

namespace carillon::dataset::samples {

namespace {

/// Mortar and the ground between pebbles.
const Vec3 deep_color(0.42, 0.40, 0.37);

/// Looks of a textured body's material: bricks are red whatever they sound like.
std::optional<render::Appearance> look_of(const scene::motion::TextureConfig& texture) {
  if (texture.map == "brick") return render::Appearance{{0.42, 0.16, 0.10}, 0.85, 0};
  if (texture.map == "pebbles") return render::Appearance{{0.45, 0.42, 0.38}, 0.6, 0};
  if (texture.map == "tiles") return render::Appearance{{0.62, 0.66, 0.66}, 0.25, 0};
  return {};
}

}  // namespace

std::string split_of_simulation(const configuration::BuildConfig& config,
                                const plan::Sample& sample) {
  return plan::part_of_split(config, sample.key, "split.simulation");
}

std::size_t part_index(const configuration::BuildConfig& config, const std::string& part) {
  const std::vector<std::string> names = config.split.names();
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), part) - names.begin());
}

render::Scene picture_of(const SimulationStage& stage, const configuration::BuildConfig& config) {
  const scene::motion::MotionConfig& motion = *config.motion;
  render::Scene scene;
  scene.camera = motion.camera->view;
  if (motion.ground) {
    render::SceneGround ground;
    ground.reach = motion.ground->side / 2;
    ground.appearance = synth::material::appearance_of(
        synth::material::parse_material(motion.ground->material, config.own_materials));
    if (motion.ground->texture) {
      ground.map = stage.moving.front().texture->map;
      ground.appearance = look_of(*motion.ground->texture).value_or(ground.appearance);
      ground.appearance.grain = render::looks::Grain::none;
      ground.deep_color = deep_color;
    }
    scene.ground = ground;
  }
  const std::size_t first = motion.ground ? 1 : 0;
  for (std::size_t b = first; b < stage.actors.size(); ++b) {
    render::SceneBody body;
    if (stage.actors[b] == nullptr) {  // the stylus
      body.mesh = pen_mesh();
      body.appearance = {{0.05, 0.06, 0.08}, 0.35, 0};
      scene.bodies.push_back(std::move(body));
      continue;
    }
    const Actor& actor = *stage.actors[b];
    body.mesh = actor.surface;
    body.appearance = actor.looks.body;
    body.faces = actor.looks.faces;
    body.texture = stage.moving[b].texture;
    if (const auto& texture = motion.bodies[b - first].texture) {
      body.appearance = look_of(*texture).value_or(body.appearance);
      body.appearance.grain = render::looks::Grain::none;  // the texture's face has none
      body.faces = {};
      body.deep_color = deep_color;
    }
    scene.bodies.push_back(std::move(body));
  }
  return scene;
}

}  // namespace carillon::dataset::samples
