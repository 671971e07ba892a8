# Compile options that every target of the project shares, and the one way to make a library.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# Installed programs find a site's libraries where they were linked.
set(CMAKE_INSTALL_RPATH_USE_LINK_PATH ON)

add_library(carillon_options INTERFACE)
target_compile_options(carillon_options INTERFACE -Wall -Wextra -Wshadow)
# GCC 12 sees these in the standard library's and Eigen's inlined code where there are none.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  target_compile_options(carillon_options INTERFACE -Wno-array-bounds -Wno-restrict
    -Wno-maybe-uninitialized -Wno-stringop-overread -Wno-stringop-overflow)
endif()
if(CARILLON_WARNINGS_AS_ERRORS)
  target_compile_options(carillon_options INTERFACE -Werror)
endif()
if(CARILLON_SANITIZE)
  target_compile_options(carillon_options INTERFACE -fsanitize=${CARILLON_SANITIZE}
                                                    -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(carillon_options INTERFACE -fsanitize=${CARILLON_SANITIZE})
endif()
# Contraction of a*b+c would make results depend on the compiler's mood.
target_compile_options(carillon_options INTERFACE -ffp-contract=off)
target_include_directories(carillon_options INTERFACE ${PROJECT_SOURCE_DIR})
# Dense products of Eigen go to BLAS, whose kernels fit the machine at run time: everywhere or
# nowhere, as one program has one definition of each of Eigen's functions.
target_compile_definitions(carillon_options INTERFACE EIGEN_USE_BLAS)

# carillon_library(NAME SOURCES ... LINK ... [PRIVATE_LINK ...] [OWN_OPTIONS]): a static library of one
# folder. OWN_OPTIONS: compiled with other options than the rest, so without the common headers.
function(carillon_library name)
  cmake_parse_arguments(ARG "OWN_OPTIONS" "" "SOURCES;LINK;PRIVATE_LINK" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC carillon_options ${ARG_LINK} PRIVATE ${ARG_PRIVATE_LINK})
  if(NOT ARG_OWN_OPTIONS)
    carillon_precompile(${name})
  endif()
endfunction()

# carillon_join_sources(TARGET [ALONE ...]): sources compiled six at a time with
# -DCARILLON_JOIN_SOURCES=ON, which halves a build from nothing and lengthens the next ones. ALONE:
# those whose unnamed namespaces share names with their neighbours'.
option(CARILLON_JOIN_SOURCES "Compile sources in groups, for builds from nothing" OFF)
function(carillon_join_sources target)
  cmake_parse_arguments(ARG "" "" "ALONE" ${ARGN})
  if(NOT CARILLON_JOIN_SOURCES)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 6)
  set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  # Names of one file's unnamed namespace are seen by the next.
  target_compile_options(${target} PRIVATE -Wno-shadow -Wno-subobject-linkage)
endfunction()
