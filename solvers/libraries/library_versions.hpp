#pragma once

#include <map>
#include <string>

namespace carillon::solvers::libraries {

/// Versions of the libraries that modes depend on, by name: petsc, slepc, metis, cholmod, mumps,
/// blas. They are part of every key of cached modes. The kernels that a BLAS chooses for the
/// machine are not named, so that equal builds say the same everywhere.
std::map<std::string, std::string> library_versions();

}  // namespace carillon::solvers::libraries
