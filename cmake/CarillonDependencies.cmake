# Everything the library is built on, by the names the folders link to. Installed beside the library, it
# finds the same for a project that uses it.
include(CarillonFind)
find_package(PkgConfig REQUIRED)
find_package(MPI REQUIRED COMPONENTS C)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(BLAS REQUIRED)
find_package(LAPACK REQUIRED)
find_package(Threads REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(CGAL REQUIRED)
find_package(pugixml REQUIRED)
find_package(hwy REQUIRED)

include(CarillonPetsc)
include(CarillonHdf5)
include(CarillonOffscreen)
carillon_pkg_config(ARCHIVE libarchive)
carillon_pkg_config(ASSIMP assimp)
carillon_pkg_config(TURBOJPEG libturbojpeg)
carillon_pkg_config(SNDFILE sndfile)
carillon_pkg_config(FFTW3 fftw3)
carillon_pkg_config(SOXR soxr)
carillon_pkg_config(MUPARSER muparser)
carillon_pkg_config(NLOPT nlopt)

# In double precision: Debian and conda name it so, and elsewhere Bullet may be built so.
pkg_check_modules(BULLET QUIET IMPORTED_TARGET GLOBAL bullet-float64)
if(NOT BULLET_FOUND)
  carillon_pkg_config(BULLET bullet)
  if(NOT "${BULLET_CFLAGS}" MATCHES BT_USE_DOUBLE_PRECISION)
    message(FATAL_ERROR "Bullet (bullet.pc) is not one in double precision, nor is there a bullet-float64.pc. Build it "
      "with -DUSE_DOUBLE_PRECISION=ON. ${CARILLON_FIND_HELP}")
  endif()
endif()

carillon_find(carillon_metis METIS LIBRARY metis HEADER metis.h)
carillon_find(carillon_gmsh GMSH LIBRARY gmsh HEADER gmsh.h)

# Direct solvers: CHOLMOD on one rank, MUMPS on a group and for inertia.
carillon_find(carillon_direct CHOLMOD LIBRARY cholmod HEADER cholmod.h SUFFIXES suitesparse)
carillon_find(carillon_direct DMUMPS LIBRARY dmumps HEADER dmumps_c.h)
# An archive does not say what else it needs; PETSc, which was linked with the same, does.
if("${CHOLMOD_LIBRARY};${DMUMPS_LIBRARY}" MATCHES "[.]a(;|$)")
  target_link_libraries(carillon_direct INTERFACE ${SLEPC_STATIC_LDFLAGS})
endif()

# Only the run-time library of OpenMP: its threads are switched off there, and no code is made for it.
# SuiteSparse's is GCC's, whatever compiles this.
add_library(carillon_openmp INTERFACE IMPORTED GLOBAL)
find_library(GOMP_LIBRARY NAMES gomp libgomp.so.1 PATHS ${CMAKE_C_IMPLICIT_LINK_DIRECTORIES})
if(GOMP_LIBRARY)
  target_link_libraries(carillon_openmp INTERFACE ${GOMP_LIBRARY})
else()
  find_package(OpenMP REQUIRED COMPONENTS CXX)
  target_link_libraries(carillon_openmp INTERFACE ${OpenMP_CXX_LIBRARIES})
endif()

# Headers alone: distributions of random numbers. CGAL needs them too.
find_package(Boost REQUIRED)
find_path(RANDOM123_INCLUDE_DIR Random123/philox.h REQUIRED)
add_library(carillon_mpi_c INTERFACE IMPORTED GLOBAL)
target_link_libraries(carillon_mpi_c INTERFACE MPI::MPI_C)
target_compile_definitions(carillon_mpi_c INTERFACE OMPI_SKIP_MPICXX MPICH_SKIP_MPICXX)
