# How dependencies are found where they do not come from Debian: under CMAKE_PREFIX_PATH, with errors
# that name what to set.

set(CARILLON_FIND_HELP "Debian: ./scripts/setup installs all packages. Elsewhere: docs/clusters.md.")

# carillon_pkg_config(SNDFILE sndfile): the target PkgConfig::SNDFILE.
function(carillon_pkg_config prefix module)
  pkg_check_modules(${prefix} QUIET IMPORTED_TARGET GLOBAL ${module})
  if(NOT ${prefix}_FOUND)
    message(FATAL_ERROR "${module} is missing: pkg-config does not know it. Add the folder that it is "
      "installed under to CMAKE_PREFIX_PATH, or the folder of its .pc file to PKG_CONFIG_PATH. "
      "${CARILLON_FIND_HELP}")
  endif()
endfunction()

# carillon_find(carillon_metis METIS LIBRARY metis HEADER metis.h [SUFFIXES suitesparse]): a library
# that brings neither a CMake configuration nor a .pc file, as an interface target. Sets METIS_LIBRARY
# and METIS_INCLUDE_DIR, which may also be given.
function(carillon_find target prefix)
  cmake_parse_arguments(ARG "" "LIBRARY;HEADER" "SUFFIXES" ${ARGN})
  find_library(${prefix}_LIBRARY ${ARG_LIBRARY})
  find_path(${prefix}_INCLUDE_DIR ${ARG_HEADER} PATH_SUFFIXES ${ARG_SUFFIXES})
  foreach(part LIBRARY INCLUDE_DIR)
    if(NOT ${prefix}_${part})
      message(FATAL_ERROR "${ARG_LIBRARY} is missing (library ${ARG_LIBRARY}, header ${ARG_HEADER}). "
        "Add the folder that it is installed under to CMAKE_PREFIX_PATH, or set ${prefix}_LIBRARY and "
        "${prefix}_INCLUDE_DIR. ${CARILLON_FIND_HELP}")
    endif()
  endforeach()
  if(NOT TARGET ${target})
    add_library(${target} INTERFACE IMPORTED GLOBAL)
  endif()
  target_link_libraries(${target} INTERFACE ${${prefix}_LIBRARY})
  target_include_directories(${target} INTERFACE ${${prefix}_INCLUDE_DIR})
endfunction()
