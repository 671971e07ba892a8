#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/build/about.hpp"
#include "cli/build/limits.hpp"
#include "cli/build/objects.hpp"
#include "cli/build/ranks.hpp"
#include "cli/motion/motion_config.hpp"
#include "cli/sound/scene.hpp"
#include "core/config.hpp"
#include "render/frame.hpp"
#include "render/voxels.hpp"
#include "solvers/solve_modes.hpp"
#include "synth/material.hpp"
#include "synth/mel.hpp"

namespace carillon::cli {

struct SplitConfig {
  double validation = 0.1;
  double test = 0.1;
  /// Parts of either split that have a share, in the order of Sound::part.
  std::vector<std::string> names() const;
  /// Cells that a sample can fall into by both splits, whose rooms and noises differ.
  std::size_t parts() const { return names().size() * names().size(); }
};

/// A build, as its configuration says; docs/configuration.md lists every key.
struct BuildConfig {
  std::string name;
  About about;
  std::uint64_t seed = 0;
  std::string materials_file;  ///< path; "" for none
  std::vector<synth::Material> own_materials;
  std::vector<ObjectSource> objects;
  VariantChoice sounding;  ///< variants of each body that samples are made of
  solvers::Band band;
  solvers::SolveOptions solver;  ///< all but the band
  solvers::MeshOptions mesh;
  double pitch_cents = 0;  ///< each shape is refined until its worst mode is within it; 0: not
  RanksConfig ranks;
  TaskLimits limits;
  Scene scene;
  std::optional<MotionConfig> motion;  ///< samples are takes of it, not strikes
  std::optional<synth::MelOptions> mel;
  std::optional<render::VoxelOptions> voxels;
  std::optional<render::Camera> camera;
  bool wav = false;
  bool png = false;
  SplitConfig split;
  std::vector<std::string> warnings;  ///< what is legal and yet worth a line when a build begins
  std::string resolved;               ///< every key with its value, YAML in SI units
};

/// Every material that the objects of a configuration name, each once, by name.
std::vector<synth::Material> named_materials(const BuildConfig& config);

/// @param text       the configuration
/// @param file_name  for messages; paths in the configuration are relative to its folder
/// @throws ConfigError  file:line:column, what is wrong and what would be right
/// @param registry   the effects that there are
/// @param with_files  faults of large files (recordings of noise) are looked for, too
BuildConfig read_build_config(const std::string& text, const std::string& file_name,
                              const std::vector<std::string>& overrides,
                              std::span<const Effect> registry = effects(), bool with_files = true);

}  // namespace carillon::cli
