#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/audio.hpp"
#include "core/config.hpp"
#include "render/frame.hpp"
#include "render/voxels.hpp"
#include "solvers/mesh_child.hpp"
#include "solvers/modes.hpp"
#include "synth/material.hpp"
#include "synth/mel.hpp"
#include "synth/ring_down.hpp"

namespace carillon::cli {

/// One entry of `objects:`: a family of generated bodies or files that match a pattern.
struct ObjectSource {
  std::string name;    ///< instances are name-000, name-001, ...; files keep their own names
  std::string family;  ///< "" for files
  int count = 1;       ///< instances of a family
  std::map<std::string, core::Range> parameters;  ///< [m], every parameter of the family
  std::vector<std::array<double, 2>> profile;     ///< of the family "turned" [m]
  std::string pattern;                            ///< glob of mesh files
  solvers::MeshFile file;              ///< options of those files; any_size counts for families too
  std::vector<std::string> materials;  ///< one variant each
  std::map<std::string, std::string> groups;  ///< instead: physical group -> material
  std::vector<double> sizes;                  ///< factors on every length
};

/// One strike that was given rather than drawn, in the body's coordinates at size 1.
struct GivenStrike {
  std::string shape;  ///< shape id; "" or "*": every shape
  solvers::Vec3 position;
  std::optional<solvers::Vec3> direction;
  double impulse;       ///< [N s]
  double contact_time;  ///< [s]
};

struct StrikeConfig {
  int per_object = 8;              ///< strikes of each shape, the same points for all its variants
  core::Range impulse;             ///< [N s], drawn uniformly in the logarithm
  core::Range contact_time;        ///< [s], likewise
  double spread = 0;               ///< [rad] largest angle between force and inward normal
  std::vector<GivenStrike> given;  ///< from a CSV file; then nothing is drawn
};

struct AudioConfig {
  double sample_rate = 44100;  ///< [Hz]
  double seconds = 1;
  core::SampleFormat dtype = core::SampleFormat::float32;
  double gain = 1;  ///< full scale per m/s (dry) or per Pa (listeners); recorded, never adapted
  std::size_t samples() const;
};

struct SplitConfig {
  double validation = 0.1;
  double test = 0.1;
};

/// A build, as its configuration says; docs/configuration.md lists every key.
struct BuildConfig {
  std::string name;
  std::uint64_t seed = 0;
  std::vector<synth::Material> own_materials;
  std::vector<ObjectSource> objects;
  solvers::Band band;
  solvers::SolveOptions solver;  ///< all but the band
  solvers::MeshOptions mesh;
  double pitch_cents = 0;  ///< each shape is refined until its worst mode is within it; 0: not
  solvers::ChildLimits mesh_limits;
  AudioConfig audio;
  StrikeConfig strikes;
  std::vector<synth::Listener> listeners;
  std::optional<synth::MelOptions> mel;
  std::optional<render::VoxelOptions> voxels;
  std::optional<render::Camera> camera;
  bool wav = false;
  bool png = false;
  SplitConfig split;
  std::string resolved;  ///< every key with its value, YAML in SI units
};

/// @param text       the configuration
/// @param file_name  for messages; paths in the configuration are relative to its folder
/// @throws ConfigError  file:line:column, what is wrong and what would be right
BuildConfig read_build_config(const std::string& text, const std::string& file_name,
                              const std::vector<std::string>& overrides);

}  // namespace carillon::cli
