# libtorch, for carillon-learn alone: it loads hundreds of libraries.
option(CARILLON_LEARN "Build carillon-learn, which train, evaluate and identify need (libtorch)" ON)
if(CARILLON_LEARN)
  find_package(Torch 1.13 QUIET)
  if(NOT Torch_FOUND)
    message(FATAL_ERROR "libtorch is missing. Debian: ./scripts/setup installs it. Elsewhere: set "
      "Torch_DIR, or leave classifiers out with -DCARILLON_LEARN=OFF. ${CARILLON_FIND_HELP}")
  endif()
endif()
