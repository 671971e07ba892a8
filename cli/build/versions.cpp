#include <CGAL/version.h>
#include <fftw3.h>
#include <fmt/format.h>
#include <gmsh.h>
#include <hdf5.h>
#include <metis.h>
#include <mpi.h>
#include <slepcsys.h>

#include <Eigen/Core>

#include "cli/build/dataset.hpp"

namespace carillon::cli {

nlohmann::json library_versions() {
  char mpi[MPI_MAX_LIBRARY_VERSION_STRING] = {};
  int length = 0;
  MPI_Get_library_version(mpi, &length);
  const std::string mpi_text(mpi, static_cast<std::size_t>(length));
  return {{"carillon", CARILLON_VERSION},
          {"compiler", "g++ " __VERSION__},
          {"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"petsc", fmt::format("{}.{}.{}", PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR,
                                PETSC_VERSION_SUBMINOR)},
          {"slepc", fmt::format("{}.{}.{}", SLEPC_VERSION_MAJOR, SLEPC_VERSION_MINOR,
                                SLEPC_VERSION_SUBMINOR)},
          {"metis", fmt::format("{}.{}.{}", METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR)},
          {"hdf5", fmt::format("{}.{}.{}", H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE)},
          {"fftw", std::string(fftw_version)},
          {"cgal", CGAL_VERSION_STR},
          {"gmsh", GMSH_API_VERSION},
          {"mpi", mpi_text.substr(0, mpi_text.find(','))}};
}

}  // namespace carillon::cli
