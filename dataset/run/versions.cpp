#include <fftw3.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <mpi.h>

#include <Eigen/Core>

#include "core/revision.hpp"
#include "dataset/run/dataset.hpp"
#include "render/frame.hpp"
#include "solvers/libraries/library_versions.hpp"

namespace carillon::dataset::run {

#ifdef __clang__
constexpr const char* compiler = "clang++ " __clang_version__;
#else
constexpr const char* compiler = "g++ " __VERSION__;
#endif

nlohmann::json program_versions() {
  char mpi[MPI_MAX_LIBRARY_VERSION_STRING] = {};
  int length = 0;
  MPI_Get_library_version(mpi, &length);
  const std::string mpi_text(mpi, static_cast<std::size_t>(length));
  nlohmann::json versions = {
      {"carillon", core::revision()},
      {"compiler", compiler},
      {"eigen",
       fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"hdf5", fmt::format("{}.{}.{}", H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE)},
      {"fftw", std::string(fftw_version)},
      {"cgal", CARILLON_CGAL_VERSION},
      {"gmsh", CARILLON_GMSH_VERSION},
      {"offscreen", render::offscreen()},
      {"mpi", mpi_text.substr(0, mpi_text.find(','))}};
  for (const auto& [library, version] : solvers::libraries::library_versions())
    versions[library] = version;
  return versions;
}

}  // namespace carillon::dataset::run
