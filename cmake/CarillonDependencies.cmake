# Everything the project is built on, by the names the folders link to.
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
find_package(CGAL REQUIRED)
find_package(hwy REQUIRED)

pkg_check_modules(SNDFILE REQUIRED IMPORTED_TARGET sndfile)
pkg_check_modules(FFTW3 REQUIRED IMPORTED_TARGET fftw3)
pkg_check_modules(SOXR REQUIRED IMPORTED_TARGET soxr)
pkg_check_modules(MUPARSER REQUIRED IMPORTED_TARGET muparser)
pkg_check_modules(OSMESA REQUIRED IMPORTED_TARGET osmesa)
pkg_check_modules(HDF5 REQUIRED IMPORTED_TARGET hdf5-openmpi)
# SLEPc requires PETSc; both real, double precision.
pkg_check_modules(SLEPC REQUIRED IMPORTED_TARGET SLEPc PETSc)

# Dense products of Eigen go to BLAS, whose kernels fit the machine at run time.
add_library(carillon_blas INTERFACE)
target_link_libraries(carillon_blas INTERFACE BLAS::BLAS)
target_compile_definitions(carillon_blas INTERFACE EIGEN_USE_BLAS)

find_library(METIS_LIBRARY metis REQUIRED)
find_path(METIS_INCLUDE_DIR metis.h REQUIRED)
add_library(carillon_metis INTERFACE)
target_link_libraries(carillon_metis INTERFACE ${METIS_LIBRARY})
target_include_directories(carillon_metis INTERFACE ${METIS_INCLUDE_DIR})

# Direct solvers: CHOLMOD on one rank, MUMPS on a group and for inertia.
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
find_library(DMUMPS_LIBRARY dmumps REQUIRED)
find_path(DMUMPS_INCLUDE_DIR dmumps_c.h REQUIRED)
add_library(carillon_direct INTERFACE)
target_link_libraries(carillon_direct INTERFACE ${CHOLMOD_LIBRARY} ${DMUMPS_LIBRARY})
target_include_directories(carillon_direct INTERFACE ${CHOLMOD_INCLUDE_DIR} ${DMUMPS_INCLUDE_DIR})

find_library(GMSH_LIBRARY gmsh REQUIRED)
find_path(GMSH_INCLUDE_DIR gmsh.h REQUIRED)
add_library(carillon_gmsh INTERFACE)
target_link_libraries(carillon_gmsh INTERFACE ${GMSH_LIBRARY})
target_include_directories(carillon_gmsh INTERFACE ${GMSH_INCLUDE_DIR})

# Headers alone: distributions of random numbers. CGAL needs them too.
find_package(Boost REQUIRED)
find_path(RANDOM123_INCLUDE_DIR Random123/philox.h REQUIRED)
add_library(carillon_mpi_c INTERFACE)
target_link_libraries(carillon_mpi_c INTERFACE MPI::MPI_C)
target_compile_definitions(carillon_mpi_c INTERFACE OMPI_SKIP_MPICXX)
