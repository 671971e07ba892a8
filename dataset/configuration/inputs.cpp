#include "dataset/configuration/inputs.hpp"

#include <fmt/format.h>

#include <set>

#include "core/files.hpp"

namespace carillon::dataset::configuration {

std::vector<InputFile> input_files(const BuildConfig& config) {
  std::vector<InputFile> files;
  const auto add = [&](const std::string& key, const std::string& path) {
    if (!path.empty()) files.push_back({key, path});
  };
  add("materials_file", config.materials_file);
  add("strikes.csv", config.scene.strikes.csv);
  std::set<std::string> manifests;
  for (const ObjectSource& source : config.objects) {
    add(fmt::format("objects[{}].profile", source.entry), source.object.profile_file);
    const std::string manifest = fmt::format("objects[{}].manifest", source.entry);
    if (manifests.insert(manifest).second) add(manifest, source.object.manifest);
  }
  if (config.motion) {
    const scene::motion::MotionConfig& motion = *config.motion;
    if (motion.ground && motion.ground->texture) {
      add("motion.ground.texture.image", motion.ground->texture->image);
    }
    std::size_t next = 0;  // repeats have one image
    for (const scene::motion::CastBody& body : motion.bodies) {
      if (body.entry < next) continue;
      next = body.entry + 1;
      if (body.texture) {
        add(fmt::format("motion.bodies[{}].texture.image", body.entry), body.texture->image);
      }
    }
  }
  return files;
}

void keep_inputs(const BuildConfig& config, const std::filesystem::path& output) {
  for (const InputFile& file : input_files(config)) {
    const std::filesystem::path copy = output / "inputs" / file.key;
    const std::string bytes = core::read_file(file.path);
    if (std::filesystem::exists(copy) && core::read_file(copy) == bytes) continue;
    core::write_text_durably(copy, bytes);
  }
}

std::string configuration_folder(const std::string& config_path) {
  return std::filesystem::absolute(config_path).lexically_normal().parent_path().string();
}

}  // namespace carillon::dataset::configuration
