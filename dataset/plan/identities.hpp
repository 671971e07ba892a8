#pragma once

#include <span>
#include <string>
#include <vector>

#include "dataset/plan/plan.hpp"

namespace carillon::dataset::plan {

/// A mesh file with all that can be an object in it.
struct FoundFile {
  FoundMesh whole;
  std::vector<FoundMesh> nodes;  ///< of a scene or a CAD file
};

/// Reads mesh files once for all that a plan needs of them; scenes and CAD files all in one process
/// of the mesher's. What is no mesh has a hash and no more, what is not there not even that: its
/// task will say why.
/// @throws FileError     a file that is there cannot be read
/// @throws StorageError  the mesher cannot be started
std::vector<FoundFile> find_files(const std::vector<std::string>& paths);

/// The objects of an entry in one of its files.
/// @throws InputError  the file has no node of a name that the entry asks for
std::vector<FoundMesh> chosen_nodes(const scene::NodeChoice& choice, const FoundFile& file);

/// Objects in the files of an entry of `objects:`, in the order of their names. Empty where nothing
/// matches.
std::vector<FoundMesh> find_meshes(const scene::Object& object);

/// SHA-256 of a mesh file; of a glTF file with the files that it names.
/// @throws FileError  it cannot be read
std::string mesh_sha256(const std::string& path);

/// Fills Shape::identity, so that one shape under two names, turned, at another size or with its
/// vertices numbered otherwise falls into one part of a split. Of files the signature's name (that
/// of the first file of equal surface; the SHA-256 where there is no signature); of generated
/// shapes the id of the first of the same proportions.
void decide_identities(std::span<Shape> shapes);

}  // namespace carillon::dataset::plan
