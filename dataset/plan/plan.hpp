#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dataset/configuration/configuration.hpp"
#include "dataset/plan/variants.hpp"
#include "solvers/mesh/shape_signature.hpp"

namespace carillon::dataset::plan {

/// The surface of a mesh file, in the file's own unit of length.
struct FileSurface {
  double unit = 1;  ///< that the file says it is in [m]
  solvers::mesh::Box bounds;
  double area = 0, volume = 0;  ///< the volume that it encloses
};

/// One object: what to mesh, and the variants that ring.
struct Shape {
  std::string id;          ///< unique in the build, e.g. bowl-001
  std::string family;      ///< label: the family, or the entry's name for files
  std::string path;        ///< mesh file; "" for generated shapes
  std::size_t source = 0;  ///< index into BuildConfig::objects
  solvers::mesh::MeshRequest request;
  scene::SolverDecision solver;
  std::vector<Variant> variants;
  std::string split_shape;  ///< train, validation or test
  std::string given_part;   ///< where the file's folder or a manifest says it; "" elsewhere
  std::string identity;     ///< what decides the split; shapes of equal surfaces have the same
  std::string sha256;       ///< of the file; "" for generated shapes
  solvers::mesh::ShapeSignature signature;    ///< of the file; empty where it cannot be read
  std::string place;                          ///< of its row in a manifest; "" where there is none
  std::map<std::string, std::string> labels;  ///< of that row
  std::optional<FileSurface> surface;  ///< of the file; nothing where it cannot be read, or holds
                                       ///< tetrahedra
};

/// One sound. Its values are a pure function of the configuration and its key.
struct Sample {
  std::string key;    ///< shape/material/size/strike-number, or simulation-number
  std::uint64_t id;   ///< stable hash of the key
  std::size_t shape;  ///< simulations: one of the cast's
  std::size_t variant;
  int strike;  ///< strike number within the shape; simulations: the simulation's number
};

enum class TaskKind { modes, samples };

struct BuildTask {
  TaskKind kind;
  std::string key;
  std::size_t shape;                   ///< simulations: one of the cast's
  std::size_t first = 0, count = 0;    ///< samples of a samples task
  std::vector<std::size_t> cast = {};  ///< simulations: all shapes that they may need
  /// Shapes whose modes must be there before a samples task begins.
  std::vector<std::size_t> needs() const {
    return cast.empty() ? std::vector<std::size_t>{shape} : cast;
  }
};

/// What a build does, before anything is done.
struct BuildPlan {
  std::vector<Shape> shapes;
  std::vector<Sample> samples;
  std::vector<BuildTask> tasks;
};

/// An object in a mesh file of an entry of `objects:`, what decides where its samples go and what
/// it will cost.
struct FoundMesh {
  std::string path;
  std::string sha256;                       ///< "" where the file is not there
  solvers::mesh::ShapeSignature signature;  ///< empty where it cannot be read
  std::optional<FileSurface> surface;       ///< as Shape::surface
  std::string node;                         ///< the object is this node alone; "": all of the file
};
/// Objects in the files of an entry by its index in BuildConfig::objects, in the order of the
/// files' names and then of their nodes.
using FindMeshes = std::function<std::vector<FoundMesh>(std::size_t)>;

/// Expands a configuration: files are looked up, parameters drawn, samples numbered.
/// @param find  mesh files; empty: those that match the entries' patterns
/// @throws InputError, FileError  a pattern matches nothing, two shapes share a name
BuildPlan make_plan(const configuration::BuildConfig& config, const FindMeshes& find = {});

/// Materials that a shape is drawn in: those that it sounds in, in the order of its variants.
std::vector<std::string> pictured_materials(const Shape& shape);
/// The same of all shapes of a plan: frames of each view.
std::size_t pictures(const BuildPlan& plan);
/// Path of a picture in the output folder: pictures/SHAPE.MATERIAL.png, and
/// pictures/SHAPE.MATERIAL.2.png of its second view.
std::string picture_name(const Shape& shape, const std::string& material, std::size_t view);

/// Shapes whose modes a sample is made from.
std::vector<std::size_t> shapes_of(const BuildPlan& plan, const Sample& sample);

/// Hash of the plan and of everything that was read for it beside the configuration: mesh files,
/// own materials, given strikes, profiles. Ranks compare it, and a folder remembers it.
std::string fingerprint(const configuration::BuildConfig& config, const BuildPlan& plan);

/// Part that a stable hash of `identity` falls into, so that a set can grow without moving anyone.
std::string part_of_split(const configuration::BuildConfig& config, const std::string& identity,
                          std::string_view purpose);

/// Part of a strike: train, validation or test, held out within its shape.
std::string split_strike(const configuration::BuildConfig& config, const Shape& shape, int strike);

}  // namespace carillon::dataset::plan
