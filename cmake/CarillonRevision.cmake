# The revision of the source (core/revision.hpp says what it looks like), at build time: each build asks
# git, and compiles one small source anew where the answer has changed. CMake runs this file with
# SOURCE, VERSION and OUTPUT for that. A source without git is taken for a release.

# carillon_revision(RESULT SOURCE VERSION)
function(carillon_revision result source version)
  # The source's own git: a tarball may have been unpacked in another one's folder.
  execute_process(
    COMMAND git --git-dir=${source}/.git describe --always --dirty --tags --abbrev=9 --match v${version}
    WORKING_DIRECTORY ${source} RESULT_VARIABLE failed OUTPUT_VARIABLE place ERROR_QUIET
    OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(failed)
    set(place v${version})
  endif()
  string(REGEX REPLACE "^v${version}-?" "" place "${place}")
  # Before its release a version counts all commits, so that packages can tell which is newer.
  if(place MATCHES "^[0-9a-f]+(-dirty)?$")
    execute_process(COMMAND git --git-dir=${source}/.git rev-list --count HEAD
      OUTPUT_VARIABLE count ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
    string(PREPEND place "${count}-g")
  endif()
  string(REPLACE "-" "." place "${place}")
  if(place)
    string(PREPEND place +)
  endif()
  set(${result} ${version}${place} PARENT_SCOPE)
endfunction()

if(CMAKE_SCRIPT_MODE_FILE)
  carillon_revision(revision ${SOURCE} ${VERSION})
  configure_file(${SOURCE}/core/revision.cpp.in ${OUTPUT} @ONLY)
  return()
endif()

set(CARILLON_REVISION_SOURCE ${PROJECT_BINARY_DIR}/revision.cpp)
add_custom_target(carillon_revision BYPRODUCTS ${CARILLON_REVISION_SOURCE}
  COMMAND ${CMAKE_COMMAND} -D SOURCE=${PROJECT_SOURCE_DIR} -D VERSION=${PROJECT_VERSION}
          -D OUTPUT=${CARILLON_REVISION_SOURCE} -P ${CMAKE_CURRENT_LIST_FILE}
  COMMENT "Asking git for the revision" VERBATIM)
