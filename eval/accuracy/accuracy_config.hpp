#pragma once

#include <optional>
#include <string>
#include <vector>

#include "eval/accuracy/feature_study.hpp"
#include "eval/accuracy/sound_study.hpp"
#include "scene/object.hpp"
#include "synth/material/material.hpp"

namespace carillon::eval::accuracy {

/// A made-up scan: the surface of a generated shape with noise on it.
struct StandIn {
  solvers::mesh::GeneratedShape shape;
  double deviation = 0;  ///< standard deviation along the normal [m]
};

/// One object of the study.
struct StudiedObject {
  std::string name;
  solvers::mesh::MeshRequest request;  ///< its shape or file; options are those of the levels
  bool any_size = false;               ///< outside 1 mm to 10 m, too
  bool optional = false;               ///< a file that may be missing
  std::optional<StandIn> stand_in;     ///< what then takes its place
  synth::material::Material material;
  std::string material_text;  ///< as it was written
  std::vector<int> orders;
  std::vector<double> size_factors;  ///< on the size that an order takes by itself
  double reference_factor = 0;       ///< such a factor for the reference's elements
};

enum class ReferenceSolver {
  automatic,     ///< harmonics where the object is turned about an axis, else tetrahedra
  axisymmetric,  ///< harmonics; other objects are refused
  tetrahedra,    ///< fine elements of a high order
};

/// What `carillon accuracy` measures; docs/accuracy.md lists every key.
struct AccuracyConfig {
  std::string name;
  solvers::modes::Band band;          ///< the lowest modes in it are compared
  std::vector<double> tolerances;     ///< of the eigensolver; the first for all levels
  std::vector<double> pitch_targets;  ///< [cent]
  std::int64_t max_elements = 200000;
  bool all_ranks = false;   ///< every level on all ranks, not on rank 0 alone
  bool cpu_time = false;    ///< levels are compared by processor time instead of wall time
  double repeat_below = 1;  ///< a level that takes less [s] is run again
  int max_runs = 3;         ///< and the fastest counts
  ReferenceSolver reference = ReferenceSolver::automatic;
  int reference_order = 4;
  std::vector<StudiedObject> objects;
  std::optional<SoundStudy> sound;
  std::optional<FeatureStudy> features;
  std::string resolved;  ///< every key with its value, YAML in SI units
};

/// Files must be there unless they are optional or have a stand-in.
/// @throws ConfigError  file:line:column, what is wrong and what would be right
AccuracyConfig read_accuracy_config(const std::string& text, const std::string& file_name,
                                    const std::vector<std::string>& overrides);

}  // namespace carillon::eval::accuracy
