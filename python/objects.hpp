#pragma once

#include <memory>
#include <string>

#include "python/runtime.hpp"
#include "scene/solved_object.hpp"

namespace carillon::python {

/// A solved object as Python holds it; never changed, so that work may share it.
struct Solved {
  std::string name;
  scene::SolvedObject object;
  std::string cache;      ///< folder; empty: none
  bool is_meshed = true;  ///< `object` has the mesh that its modes were solved on
};

using SolvedPointer = std::shared_ptr<Solved>;

/// Numbers in whatever array they come, as [count, 3].
using Triples = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// @param what  for messages
/// @throws InputError  another shape, or a number that is not finite
std::vector<Vec3> vectors_of(const Triples& array, const std::string& what);

/// @throws InputError  not three finite numbers
Vec3 vector_of(const Triples& array, const std::string& what);

}  // namespace carillon::python
