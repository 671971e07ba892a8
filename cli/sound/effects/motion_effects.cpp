#include "cli/sound/effects/list.hpp"
#include "cli/sound/scene.hpp"
#include "core/hash.hpp"

namespace carillon::cli {

namespace {

// One core of a 2.3 GHz Xeon (docs/scenes.md).
constexpr double kSecondsPerBodyStep = 2e-5;
constexpr double kSecondsPerContactSample = 1e-7;  ///< of a body
constexpr double kSecondsPerTick = 2e-6;
constexpr double kSecondsPerPixel = 1.5e-6;

/// Bodies of the cast.
double cast_size(core::ConfigNode& motion) {
  double count = 0;
  for (core::ConfigNode& body : motion.children("bodies")) {
    count += body.has("repeat")
                 ? static_cast<double>(body.child("repeat").integer("count", 1, 10000))
                 : 1.0;
  }
  return count;
}

SceneEffect asked(core::ConfigNode& root) {
  SceneEffect effect;
  if (root.has("motion")) {
    effect.asked_by = "motion: (" + root.where("motion") + ")";
  } else {
    effect.reason_off = "nothing moves: no motion:";
  }
  return effect;
}

/// Images of textures that a motion reads, where they are.
std::vector<std::string> images_of(core::ConfigNode& motion, const std::string& file_name) {
  std::vector<std::string> images;
  const auto add = [&](core::ConfigNode node) {
    if (!node.has("texture")) return;
    core::ConfigNode texture = node.child("texture");
    if (texture.has("image")) {
      images.push_back(core::path_beside(file_name, texture.text("image")));
    }
  };
  if (motion.has("ground")) add(motion.child("ground"));
  for (core::ConfigNode& body : motion.children("bodies")) add(body);
  return images;
}

SceneEffect read_motion_effect(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect = asked(root);
  if (!effect.reason_off.empty()) return effect;
  core::ConfigNode motion = root.child("motion");
  const double step = motion.quantity("step", core::Dimension::time, 0.001);
  effect.seconds_per_sound = kSecondsPerBodyStep * cast_size(motion) * scene.audio.seconds / step;
  const std::vector<std::string> images = images_of(motion, scene.file_name);
  if (!images.empty()) {
    effect.content = [images] {
      std::string hashes;
      for (const std::string& image : images) hashes += core::sha256_file(image) + " ";
      return hashes;
    };
  }
  return effect;
}

SceneEffect read_contacts_effect(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect = asked(root);
  if (!effect.reason_off.empty()) return effect;
  core::ConfigNode motion = root.child("motion");
  effect.seconds_per_sound =
      kSecondsPerContactSample * cast_size(motion) * static_cast<double>(scene.audio.samples());
  return effect;
}

SceneEffect read_damping_effect(core::ConfigNode& root, const Scene&) {
  return asked(root);
}

SceneEffect read_touch_effect(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect = asked(root);
  if (!effect.reason_off.empty()) return effect;
  core::ConfigNode motion = root.child("motion");
  if (!motion.has("stylus")) {
    effect.asked_by.clear();
    effect.reason_off = "no motion.stylus:";
    return effect;
  }
  effect.asked_by = "motion.stylus: (" + motion.where("stylus") + ")";
  effect.seconds_per_sound =
      kSecondsPerTick * scene.audio.seconds / motion.quantity("step", core::Dimension::time, 0.001);
  return effect;
}

SceneEffect read_movie_effect(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect = asked(root);
  if (!effect.reason_off.empty()) return effect;
  core::ConfigNode motion = root.child("motion");
  if (!motion.has("camera")) {
    effect.asked_by.clear();
    effect.reason_off = "no motion.camera:";
    return effect;
  }
  core::ConfigNode camera = motion.child("camera");
  effect.asked_by = "motion.camera: (" + motion.where("camera") + ")";
  const double pixels = static_cast<double>(camera.integer("width", 1, 4096, 128)) *
                        static_cast<double>(camera.integer("height", 1, 4096, 128));
  effect.seconds_per_sound = kSecondsPerPixel * pixels * scene.audio.seconds *
                             camera.quantity("rate", core::Dimension::frequency, 25);
  return effect;
}

}  // namespace

const Effect motion_effect = {.name = "motion",
                              .description = "bodies that fall, roll and collide (Bullet)",
                              .key = "motion",
                              .stage = "motion",
                              .read = read_motion_effect};
const Effect lasting_contacts_effect = {.name = "lasting_contacts",
                                        .description = "sound of what rolls and scrapes",
                                        .key = "motion",
                                        .stage = "motion",
                                        .read = read_contacts_effect};
const Effect contact_damping_effect = {.name = "contact_damping",
                                       .description = "damping by what bodies rest on meanwhile",
                                       .key = "motion",
                                       .stage = "motion",
                                       .read = read_damping_effect};
const Effect touch_effect = {.name = "touch",
                             .description = "force vectors of a stylus drawn over a texture",
                             .key = "motion",
                             .stage = "motion",
                             .read = read_touch_effect};
const Effect movie_effect = {.name = "movie",
                             .description = "frames of the moving scene, depth and masks",
                             .key = "motion",
                             .stage = "motion",
                             .read = read_movie_effect};

}  // namespace carillon::cli
