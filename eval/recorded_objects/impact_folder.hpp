#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/npy.hpp"
#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::eval::recorded_objects {

/// One object of RealImpact (Clarke et al. 2023), or recordings of one's own in the same layout:
/// row n of every array belongs to recording n. Recordings stay in their file.
struct ImpactFolder {
  std::string name;            ///< of the object, as 22_Cup
  std::filesystem::path mesh;  ///< in metres, in the coordinates of the positions
  Vec3 centre;                 ///< of the box about transformed.obj [m]
  core::NpyFile recordings;    ///< rows x samples: pressure
  /// By the hammer's force: sample 0 is when the hammer touches. Otherwise as it was recorded.
  bool deconvolved = true;
  /// The hammer's, of recordings that are not deconvolved: one row for each recording, or for so
  /// many in turn as were made of one strike.
  std::optional<core::NpyFile> forces;
  std::vector<std::int64_t> vertices;              ///< of the mesh, struck; from 0
  std::vector<Vec3> struck;                        ///< their positions [m]
  std::vector<Vec3> listeners;                     ///< positions of the microphones [m]
  std::optional<std::vector<double>> angles;       ///< of the gantry [degrees]; none: no such file
  std::optional<std::vector<double>> distances;    ///< of the gantry [mm]
  std::optional<std::vector<double>> microphones;  ///< number along the column, from 0

  std::size_t rows() const { return vertices.size(); }
  std::size_t samples() const { return recordings.row_size(); }
};

/// @param folder      of the object, or its folder `preprocessed`
/// @param mesh        in place of the folder's transformed.obj; "": that one
/// @param recordings  array of the folder, deconvolved if its name begins so; "":
///                    deconvolved_0db.npy, or sounds_0db.npy where that is missing
/// @throws FileError   a file is missing or cannot be read
/// @throws InputError  arrays whose rows do not agree or that have another extent, a position that
///                     is not finite, a vertex that the mesh does not have or that lies elsewhere;
///                     names file and row
ImpactFolder read_impact_folder(const std::filesystem::path& folder, const std::string& mesh,
                                const std::string& recordings);

/// Samples of one recording.
/// @throws InputError  a sample that is not finite; names file, row and sample
std::vector<double> read_recording(const ImpactFolder& folder, std::size_t row);

/// The hammer's force in a recording, of any unit; empty where it is not known.
/// @throws InputError  a sample that is not finite; names file, row and sample
std::vector<double> read_force(const ImpactFolder& folder, std::size_t row);

/// The preset material whose name is a word of an object's: iron of 17_IronSkillet, ceramic of
/// 9_BowlCeramic; "metal" is taken for steel. "" where no word is one, or several are.
std::string material_in_name(const std::string& name);

}  // namespace carillon::eval::recorded_objects
