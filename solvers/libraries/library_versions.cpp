#include "solvers/libraries/library_versions.hpp"

#include <cholmod.h>
#include <dmumps_c.h>
#include <fmt/core.h>
#include <metis.h>
#include <slepcsys.h>

#include "solvers/libraries/detail/blas_library.hpp"

namespace carillon::solvers::libraries {

std::map<std::string, std::string> library_versions() {
  int cholmod[3] = {};
  cholmod_version(cholmod);
  return {{"petsc", fmt::format("{}.{}.{}", PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR,
                                PETSC_VERSION_SUBMINOR)},
          {"slepc", fmt::format("{}.{}.{}", SLEPC_VERSION_MAJOR, SLEPC_VERSION_MINOR,
                                SLEPC_VERSION_SUBMINOR)},
          {"metis", fmt::format("{}.{}.{}", METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR)},
          {"cholmod", fmt::format("{}.{}.{}", cholmod[0], cholmod[1], cholmod[2])},
          {"mumps", MUMPS_VERSION},
          {"blas", blas_version()}};
}

}  // namespace carillon::solvers::libraries
