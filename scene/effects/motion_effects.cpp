#include "core/hash.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/picture.hpp"
#include "scene/scene.hpp"

namespace carillon::scene {

namespace {

/// @param part  key of `motion` that asks for the effect; "": all of it does
SceneEffect asked(core::ConfigNode& root, const std::string& part = "") {
  SceneEffect effect;
  if (!root.has("motion")) {
    effect.reason_off = "nothing moves: no motion:";
    return effect;
  }
  core::ConfigNode motion = root.child("motion");
  if (part.empty()) {
    effect.asked_by = "motion: (" + root.where("motion") + ")";
  } else if (motion.has(part)) {
    effect.asked_by = "motion." + part + ": (" + motion.where(part) + ")";
  } else {
    effect.reason_off = "no motion." + part + ":";
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

SceneEffect read_asked(core::ConfigNode& root, const Scene&) {
  return asked(root);
}

SceneEffect read_touch_effect(core::ConfigNode& root, const Scene&) {
  return asked(root, "stylus");
}

SceneEffect read_movie_effect(core::ConfigNode& root, const Scene&) {
  SceneEffect effect = asked(root, "camera");
  if (!effect.reason_off.empty()) return effect;
  effect.check = [motion = root.child("motion")] {
    require_pictures(motion, "camera", movie_effect.name);
  };
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
                                        .read = read_asked};
const Effect contact_damping_effect = {.name = "contact_damping",
                                       .description = "damping by what bodies rest on meanwhile",
                                       .key = "motion",
                                       .stage = "motion",
                                       .read = read_asked};
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

}  // namespace carillon::scene
