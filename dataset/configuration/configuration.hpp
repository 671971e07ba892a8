#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "dataset/configuration/about.hpp"
#include "dataset/configuration/limits.hpp"
#include "dataset/configuration/objects.hpp"
#include "dataset/configuration/ranks.hpp"
#include "render/frame.hpp"
#include "render/voxels.hpp"
#include "scene/modes_config.hpp"
#include "scene/motion/motion_config.hpp"
#include "scene/scene.hpp"
#include "synth/material/material.hpp"
#include "synth/signal/mel.hpp"

namespace carillon::dataset::configuration {

struct SplitConfig {
  double validation = 0.1;
  double test = 0.1;
  /// Parts of either split that have a fraction, in the order of Sound::part.
  std::vector<std::string> names() const;
  /// Cells that a sample can fall into by both splits, whose rooms and noises differ.
  std::size_t parts() const { return names().size() * names().size(); }
};

/// A build, as its configuration says; docs/configuration.md lists every key.
struct BuildConfig : scene::ModesConfig {
  std::string name;
  About about;
  std::uint64_t seed = 0;
  std::string materials_file;  ///< path; "" for none
  std::vector<synth::material::Material> own_materials;
  std::vector<ObjectSource> objects;
  VariantChoice sounding;  ///< variants of each object that samples are made of
  MaterialSpread spread;   ///< of the constants of materials
  RanksConfig ranks;
  TaskLimits limits;
  scene::Scene scene;
  std::optional<scene::motion::MotionConfig>
      motion;  ///< samples are simulations of it, not strikes
  std::optional<synth::signal::MelOptions> mel;
  std::optional<render::VoxelOptions> voxels;
  std::vector<render::Camera> cameras;  ///< of the objects' frames, one for each view; empty: none
  bool wav = false;
  bool png = false;
  SplitConfig split;
  std::vector<std::string> warnings;  ///< what is legal and yet worth a line when a build begins
  std::string resolved;               ///< every key with its value, YAML in SI units
};

/// Names of all labels that manifests give, in their order.
std::set<std::string> named_labels(const BuildConfig& config);

/// Materials that a shape of an entry of `objects` sounds in.
std::size_t sounding_materials(const BuildConfig& config, const ObjectSource& source);

/// Every material that the objects of a configuration name, each once, by name.
std::vector<synth::material::Material> named_materials(const BuildConfig& config);

/// @param text       the configuration
/// @param file_name  for messages; paths in the configuration are relative to its folder
/// @throws ConfigError  file:line:column, what is wrong and what would be right
/// @param registry   the effects that there are
/// @param with_files  faults of large files (recordings of noise) are looked for, too
BuildConfig read_build_config(const std::string& text, const std::string& file_name,
                              const std::vector<std::string>& overrides,
                              std::span<const scene::Effect> registry = scene::effects(),
                              bool with_files = true);

}  // namespace carillon::dataset::configuration
