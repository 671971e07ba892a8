#pragma once

#include <span>
#include <string>
#include <vector>

#include "dataset/plan/plan.hpp"

namespace carillon::dataset::plan {

/// Reads a mesh file once for all that a plan needs of it.
/// @throws FileError  it cannot be read; what is no mesh has a hash and no more: its task will say
/// why
FoundMesh find_mesh(const std::string& path);

/// Mesh files of an entry of `objects:`, in the order of their names. Empty where nothing matches.
std::vector<FoundMesh> find_meshes(const scene::Object& object);

/// Fills Shape::identity, so that one shape under two names, turned, at another size or with its
/// vertices numbered otherwise falls into one part of a split. Of files the signature's name (that
/// of the first file of equal surface; the SHA-256 where there is no signature); of generated
/// shapes the id of the first of the same proportions.
void decide_identities(std::span<Shape> shapes);

}  // namespace carillon::dataset::plan
