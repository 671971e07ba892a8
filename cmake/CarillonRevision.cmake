# carillon_revision.hpp: which commit a program is made of, looked up by every build and written anew
# only when it is another one. Where the sources are no clone, -DCARILLON_REVISION=... says it.
set(CARILLON_REVISION "" CACHE STRING "The commit, where git cannot tell (default: git describe)")
set(CARILLON_GENERATED ${PROJECT_BINARY_DIR}/generated)
find_package(Git QUIET)
add_custom_target(carillon_revision
  COMMAND ${CMAKE_COMMAND} -D GIT=${GIT_EXECUTABLE} -D SOURCE=${PROJECT_SOURCE_DIR}
          -D REVISION=${CARILLON_REVISION} -D OUTPUT=${CARILLON_GENERATED}/carillon_revision.hpp
          -P ${PROJECT_SOURCE_DIR}/cmake/write_revision.cmake
  BYPRODUCTS ${CARILLON_GENERATED}/carillon_revision.hpp
  VERBATIM)
