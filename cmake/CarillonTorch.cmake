# libtorch and liblinear, for carillon-learn alone: the first loads hundreds of libraries.
option(CARILLON_LEARN "Build carillon-learn, which train, evaluate and identify need (libtorch)" ON)
if(CARILLON_LEARN)
  find_package(Torch 1.13 QUIET)
  if(NOT Torch_FOUND)
    message(FATAL_ERROR "libtorch is missing. Debian: ./scripts/setup installs it. Elsewhere: set "
      "Torch_DIR, or leave classifiers out with -DCARILLON_LEARN=OFF. ${CARILLON_FIND_HELP}")
  endif()
  # Linear support vector machines.
  carillon_find(carillon_linear LIBLINEAR LIBRARY linear HEADER linear.h SUFFIXES liblinear)
endif()

# libtorch's headers have a vector of a type that is not complete yet, which Clang refuses in C++20 with
# libstdc++: carillon_compile_with_gcc(TARGET) compiles the sources that include them with GCC.
function(carillon_compile_with_gcc target)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    return()
  endif()
  # Clang's own options go.
  set_property(TARGET ${target} PROPERTY COMPILE_OPTIONS $<$<CONFIG:Release>:-O1>)
  find_program(CARILLON_GXX NAMES g++-12 g++ REQUIRED)
  set_target_properties(${target} PROPERTIES CXX_COMPILER_LAUNCHER
    "${PROJECT_SOURCE_DIR}/cmake/instead;${CMAKE_CXX_COMPILER_LAUNCHER};${CARILLON_GXX};--")
endfunction()
