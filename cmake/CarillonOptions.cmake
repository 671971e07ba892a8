# Compile options that every target of the project shares, and the one way to make a library.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# Installed programs find a site's libraries where they were linked.
set(CMAKE_INSTALL_RPATH_USE_LINK_PATH ON)

add_library(carillon_options INTERFACE)
target_compile_options(carillon_options INTERFACE -Wall -Wextra -Wshadow)
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

# carillon_library(NAME SOURCES ... LINK ...): a static library of one folder.
function(carillon_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC carillon_options ${ARG_LINK})
endfunction()
