#include "eval/recorded_objects/impact_folder.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "core/error.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "synth/material/material.hpp"

namespace carillon::eval::recorded_objects {

namespace {

using core::InputError;
namespace fs = std::filesystem;

constexpr const char* deconvolved_name = "deconvolved_0db.npy";
constexpr const char* recorded_name = "sounds_0db.npy";
constexpr const char* mesh_name = "transformed.obj";
/// How far a vertex of the mesh may lie from where the folder says it is, as a fraction of the
/// object's longest side.
constexpr double elsewhere = 0.02;

/// The array of recordings of an object's folder.
/// @param name  of the array; "": the dataset's own
fs::path find_recordings(const fs::path& folder, const std::string& name) {
  if (!fs::is_directory(folder)) {
    throw core::FileError(fmt::format("{}: no such folder", folder.string()),
                          "give the folder of one object, such as dataset/22_Cup");
  }
  const std::vector<std::string> names =
      name.empty() ? std::vector<std::string>{deconvolved_name, recorded_name}
                   : std::vector<std::string>{name};
  for (const std::string& one : names) {
    for (const fs::path& place : {folder, folder / "preprocessed"}) {
      if (fs::exists(place / one)) return place / one;
    }
  }
  throw core::FileError(
      fmt::format("{}: there is no {}, here or in preprocessed/", folder.string(), names.front()),
      "give the folder of one object as the dataset's download.sh unpacks it; --recordings names "
      "another array");
}

/// Forces of recordings as they were made, where the folder has them.
std::optional<core::NpyFile> find_forces(const fs::path& place, const core::NpyFile& recordings) {
  for (const char* name : {"hammer_newtons.npy", "hammers.npy"}) {
    const fs::path path = place / name;
    if (!fs::exists(path)) continue;
    core::NpyFile forces(path);
    if (forces.extent().size() != 2 || forces.rows() == 0 || forces.row_size() == 0 ||
        recordings.rows() % forces.rows() != 0) {
      throw InputError(
          fmt::format("{}: an array of {}, where {} has {} rows", path.string(),
                      fmt::join(forces.extent(), " x "), recordings.path().filename().string(),
                      recordings.rows()),
          "one row of force for each recording is expected, or for so many in turn as were made of "
          "one strike");
    }
    return forces;
  }
  return std::nullopt;
}

/// Of an object's folder, whichever way it was named.
std::string object_name(const fs::path& place) {
  fs::path whole = fs::weakly_canonical(fs::absolute(place));
  if (whole.filename() == "preprocessed") whole = whole.parent_path();
  return whole.filename().string();
}

std::vector<double> read_row(const core::NpyFile& file, std::size_t row) {
  std::vector<double> samples = file.read_rows(row, 1);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::isfinite(samples[i])) continue;
    throw InputError(
        fmt::format("{}: sample {} of row {} is not finite", file.path().string(), i, row));
  }
  return samples;
}

/// Words of a name: letters of one case after another, IronSkillet as iron and skillet.
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words(1);
  bool lower = false;
  for (const char letter : name) {
    const auto code = static_cast<unsigned char>(letter);
    if (std::isalpha(code) == 0 || (std::isupper(code) != 0 && lower)) words.emplace_back();
    lower = std::islower(code) != 0;
    if (std::isalpha(code) != 0) words.back() += static_cast<char>(std::tolower(code));
  }
  std::erase(words, "");
  return words;
}

core::NpyFile open_array(const fs::path& path) {
  if (!fs::exists(path)) {
    throw core::FileError(fmt::format("{}: no such file", path.string()),
                          "docs/realimpact.md lists the files of an object");
  }
  return core::NpyFile(path);
}

/// Numbers of an array with so many columns for each recording.
std::vector<double> read_columns(const fs::path& path, std::uint64_t rows, std::uint64_t columns) {
  const core::NpyFile file = open_array(path);
  const std::uint64_t axes = columns == 1 ? 1 : 2;
  if (file.extent().empty() || file.row_size() != columns ||
      (file.extent().size() != axes && columns != 1)) {
    throw InputError(fmt::format("{}: an array of {}, where recordings x {} is expected",
                                 path.string(), fmt::join(file.extent(), " x "), columns));
  }
  if (file.rows() != rows) {
    throw InputError(
        fmt::format("{}: {} rows, but there are {} recordings", path.string(), file.rows(), rows),
        "all arrays of an object have one row for each recording");
  }
  return file.read_rows(0, rows);
}

std::vector<Vec3> read_positions(const fs::path& path, std::uint64_t rows) {
  const std::vector<double> values = read_columns(path, rows, 3);
  std::vector<Vec3> positions;
  for (std::size_t row = 0; row < rows; ++row) {
    positions.emplace_back(values[3 * row], values[3 * row + 1], values[3 * row + 2]);
    if (!positions.back().allFinite()) {
      throw InputError(fmt::format("{}: row {} is not finite", path.string(), row));
    }
  }
  return positions;
}

std::optional<std::vector<double>> read_labels(const fs::path& path, std::uint64_t rows) {
  if (!fs::exists(path)) return std::nullopt;
  return read_columns(path, rows, 1);
}

std::vector<std::int64_t> read_vertices(const fs::path& path, std::uint64_t rows, std::size_t count,
                                        const fs::path& mesh) {
  std::vector<std::int64_t> vertices;
  for (const double value : read_columns(path, rows, 1)) {
    if (!(value >= 0 && value < static_cast<double>(count)) || value != std::floor(value)) {
      throw InputError(
          fmt::format("{}: row {} names vertex {}, but {} has vertices 0 to {}", path.string(),
                      vertices.size(), value, mesh.string(), static_cast<double>(count) - 1),
          "the mesh is another one than the recordings were labelled with");
    }
    vertices.push_back(static_cast<std::int64_t>(value));
  }
  return vertices;
}

/// A vertex lies where the mesh has it, in all rows.
void check_struck(const ImpactFolder& folder, const solvers::mesh::SurfaceMesh& mesh) {
  const double size = solvers::mesh::bounding_box(mesh.vertices).longest_side();
  for (std::size_t row = 0; row < folder.rows(); ++row) {
    const Vec3& there = mesh.vertices[static_cast<std::size_t>(folder.vertices[row])];
    const double distance = (there - folder.struck[row]).norm();
    if (distance <= elsewhere * size) continue;
    throw InputError(
        fmt::format("row {}: vertexXYZ.npy has vertex {} at ({:.4g}), but {} at ({:.4g})", row,
                    folder.vertices[row], fmt::join(folder.struck[row], ", "), folder.mesh.string(),
                    fmt::join(there, ", ")),
        "mesh and positions must be in the same coordinates, in metres");
  }
}

}  // namespace

ImpactFolder read_impact_folder(const fs::path& folder, const std::string& mesh,
                                const std::string& recordings) {
  const fs::path array = find_recordings(folder, recordings);
  const fs::path place = array.parent_path();
  ImpactFolder read{.name = object_name(place),
                    .mesh = mesh.empty() ? place / mesh_name : fs::path(mesh),
                    .centre = Vec3::Zero(),
                    .recordings = core::NpyFile(array),
                    .deconvolved = array.filename().string().starts_with("deconvolved"),
                    .forces = {},
                    .vertices = {},
                    .struck = {},
                    .listeners = {},
                    .angles = {},
                    .distances = {},
                    .microphones = {}};
  if (read.recordings.extent().size() != 2 || read.recordings.rows() == 0 ||
      read.recordings.row_size() == 0) {
    throw InputError(fmt::format("{}: an array of {}, where recordings x samples is expected",
                                 array.string(), fmt::join(read.recordings.extent(), " x ")));
  }
  if (!read.deconvolved) read.forces = find_forces(place, read.recordings);
  if (!fs::exists(place / mesh_name)) {
    throw core::FileError(fmt::format("{}: no such file", (place / mesh_name).string()),
                          "vertexID.npy counts its vertices; --mesh gives another one to solve");
  }
  const solvers::mesh::SurfaceMesh labelled =
      solvers::mesh::readers::read_surface((place / mesh_name).string());
  const solvers::mesh::Box box = solvers::mesh::bounding_box(labelled.vertices);
  read.centre = 0.5 * (box.low + box.high);
  const std::uint64_t rows = read.recordings.rows();
  read.vertices =
      read_vertices(place / "vertexID.npy", rows, labelled.vertices.size(), place / mesh_name);
  read.struck = read_positions(place / "vertexXYZ.npy", rows);
  read.listeners = read_positions(place / "listenerXYZ.npy", rows);
  read.angles = read_labels(place / "angle.npy", rows);
  read.distances = read_labels(place / "distance.npy", rows);
  read.microphones = read_labels(place / "micID.npy", rows);
  check_struck(read, labelled);
  return read;
}

std::vector<double> read_recording(const ImpactFolder& folder, std::size_t row) {
  return read_row(folder.recordings, row);
}

std::vector<double> read_force(const ImpactFolder& folder, std::size_t row) {
  if (!folder.forces) return {};
  return read_row(*folder.forces, row / (folder.rows() / folder.forces->rows()));
}

std::string material_in_name(const std::string& name) {
  constexpr std::size_t shortest = 4;  // of a pet's bowl and a tin opener nothing is said
  std::set<std::string> found;
  for (const std::string& word : words_of(name)) {
    if (word.size() < shortest) continue;
    if (word == "metal") found.insert("steel");
    for (const synth::material::Material& preset : synth::material::preset_materials()) {
      if (preset.name == word) found.insert(word);
    }
  }
  return found.size() == 1 ? *found.begin() : "";
}

}  // namespace carillon::eval::recorded_objects
