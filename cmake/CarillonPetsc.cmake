# PETSc and SLEPc, real numbers in double precision: Debian's, or a site's own by PETSC_DIR, SLEPC_DIR
# and PETSC_ARCH (empty for an installed PETSc) as variables of CMake or of the environment. What PETSc
# was built with (METIS, MUMPS, SuiteSparse, HDF5 by --download-...) is then taken from there too.
foreach(variable PETSC_DIR PETSC_ARCH SLEPC_DIR)
  set(${variable} "$ENV{${variable}}" CACHE STRING
      "Site's own PETSc or SLEPc; empty: as pkg-config finds it")
  if(NOT ${variable})
    set(${variable} "$ENV{${variable}}")
  endif()
endforeach()

set(names_of_PETSC PETSc.pc petsc.pc)
set(names_of_SLEPC SLEPc.pc slepc.pc)
foreach(package SLEPC PETSC)
  if(NOT ${package}_DIR)
    continue()
  endif()
  set(prefixes ${${package}_DIR}/${PETSC_ARCH} ${${package}_DIR})
  find_file(${package}_PC NAMES ${names_of_${package}} NO_CACHE
            NO_DEFAULT_PATH PATHS ${prefixes} PATH_SUFFIXES lib/pkgconfig lib64/pkgconfig)
  if(NOT ${package}_PC)
    message(FATAL_ERROR "${package}_DIR=${${package}_DIR} holds no lib/pkgconfig/*.pc of it, nor does "
      "its folder PETSC_ARCH=\"${PETSC_ARCH}\". Set ${package}_DIR and PETSC_ARCH as PETSc's `make` "
      "printed them; PETSC_ARCH is empty for an installed one.")
  endif()
  list(PREPEND CMAKE_PREFIX_PATH ${prefixes})
endforeach()

pkg_check_modules(SLEPC QUIET IMPORTED_TARGET SLEPc PETSc>=3.18)
if(NOT SLEPC_FOUND)
  message(FATAL_ERROR "SLEPc and PETSc 3.18 or newer are missing (or one of them). Set PETSC_DIR, "
    "SLEPC_DIR and, for a PETSc that was not installed, PETSC_ARCH. ${CARILLON_FIND_HELP}")
endif()

# What its own sources were compiled with is no concern of ours.
set_property(TARGET PkgConfig::SLEPC PROPERTY INTERFACE_COMPILE_OPTIONS)

# Real numbers in double precision, with MPI.
include(CheckCSourceCompiles)
set(CMAKE_REQUIRED_INCLUDES ${SLEPC_INCLUDE_DIRS} ${MPI_C_INCLUDE_DIRS})
check_c_source_compiles("#include <petscconf.h>
  #if defined(PETSC_USE_COMPLEX) || !defined(PETSC_USE_REAL_DOUBLE) || defined(PETSC_HAVE_MPIUNI)
  #error
  #endif
  int main(void) { return 0; }" CARILLON_PETSC_FITS)
unset(CMAKE_REQUIRED_INCLUDES)
if(NOT CARILLON_PETSC_FITS)
  unset(CARILLON_PETSC_FITS CACHE)
  message(FATAL_ERROR "PETSc in ${SLEPC_INCLUDE_DIRS} is not one for real numbers in double precision "
    "with MPI. Set PETSC_DIR and PETSC_ARCH to one configured with --with-scalar-type=real "
    "--with-precision=double.")
endif()
