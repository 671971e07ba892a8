# Compile options that every target of the project shares, and the one way to make a library.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Precompiled headers are cached by what is in them, not by when they were made; and Clang, asked to
  # preprocess alone, leaves them out, so that what a source includes is read from its dependencies.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_DEPEND=1
      CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${CCACHE_PROGRAM})
endif()

# Programs find a site's libraries where they were linked; in the build folder too, where CMake would
# otherwise fill the path up with the current folder.
set(CMAKE_INSTALL_RPATH_USE_LINK_PATH ON)
set(CMAKE_BUILD_WITH_INSTALL_RPATH ON)

option(CARILLON_JOIN_SOURCES "Compile sources in groups, for builds from nothing" OFF)

# What belongs to the headers, so that it is told to whom the library is installed for; and what is for
# building them alone.
add_library(carillon_interface INTERFACE)
target_compile_features(carillon_interface INTERFACE cxx_std_20)
target_include_directories(carillon_interface INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                        $<INSTALL_INTERFACE:include>)
# Dense products of Eigen go to BLAS, whose kernels fit the machine at run time: everywhere or
# nowhere, as one program has one definition of each of Eigen's functions.
target_compile_definitions(carillon_interface INTERFACE EIGEN_USE_BLAS)
target_link_libraries(carillon_interface INTERFACE BLAS::BLAS)

add_library(carillon_options INTERFACE)
target_link_libraries(carillon_options INTERFACE carillon_interface)
# Clang wants two pairs of braces around what initialises an array.
target_compile_options(carillon_options INTERFACE -Wall -Wextra -Wno-missing-braces)
# Where sources are joined, names of one file's unnamed namespace are seen by the next.
if(NOT CARILLON_JOIN_SOURCES)
  target_compile_options(carillon_options INTERFACE -Wshadow)
elseif(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  target_compile_options(carillon_options INTERFACE -Wno-subobject-linkage)
endif()
# GCC 12 sees these in the standard library's and Eigen's inlined code where there are none.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  target_compile_options(carillon_options INTERFACE -Wno-array-bounds -Wno-restrict
    -Wno-maybe-uninitialized -Wno-stringop-overread -Wno-stringop-overflow)
endif()
if(CARILLON_PYTHON)
  # The Python module is a shared library of the same objects.
  target_compile_options(carillon_options INTERFACE -fPIC)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    target_compile_options(carillon_options INTERFACE -fno-semantic-interposition)
  endif()
endif()
if(CARILLON_WARNINGS_AS_ERRORS)
  target_compile_options(carillon_options INTERFACE -Werror)
endif()
if(CARILLON_SANITIZE)
  target_compile_options(carillon_options INTERFACE -fsanitize=${CARILLON_SANITIZE}
                                                    -fno-omit-frame-pointer -fno-sanitize-recover=all)
  if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
    target_compile_options(carillon_options INTERFACE
      -fsanitize-ignorelist=${PROJECT_SOURCE_DIR}/cmake/sanitizers.txt)
  endif()
  target_link_options(carillon_options INTERFACE -fsanitize=${CARILLON_SANITIZE})
endif()
# Contraction of a*b+c would make results depend on the compiler's mood.
target_compile_options(carillon_options INTERFACE -ffp-contract=off)

# How what is no kernel is optimised in a release.
set(CARILLON_REST_OPTIONS $<$<CONFIG:Release>:-O1>)
if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
  list(APPEND CARILLON_REST_OPTIONS "$<$<CONFIG:Release>:SHELL:-mllvm -inline-threshold=25>")
endif()

# carillon_library(NAME SOURCES ... LINK ... [PRIVATE_LINK ...] [KERNELS] [ALONE ...] [OWN_OPTIONS]
#                  [PROGRAMS]): a static library of one folder. KERNELS: most of a run's time is spent
# here, so it is optimised in full; the rest of a release is compiled at -O1, in two thirds of the time.
# ALONE: sources that are not joined with others, as they take long alone or share names of unnamed
# namespaces with their neighbours. OWN_OPTIONS: compiled with other options than the rest, so without the common headers.
# PROGRAMS: for the project's own programs alone, so not installed.
function(carillon_library name)
  cmake_parse_arguments(ARG "KERNELS;OWN_OPTIONS;PROGRAMS" "" "SOURCES;LINK;PRIVATE_LINK;ALONE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC carillon_interface $<BUILD_INTERFACE:carillon_options> ${ARG_LINK}
                                PRIVATE ${ARG_PRIVATE_LINK})
  # Sizes, counts and indices keep their bits, and numbers their digits, unless a cast says otherwise.
  if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
    target_compile_options(${name} PRIVATE -Wconversion -Wno-sign-conversion)
  endif()
  if(ARG_KERNELS)
    set(kind kernels)
  else()
    set(kind rest)
    target_compile_options(${name} PRIVATE ${CARILLON_REST_OPTIONS})
  endif()
  if(NOT ARG_OWN_OPTIONS)
    carillon_precompile(${name} ${kind})
  endif()
  carillon_join_sources(${name} ${ARG_ALONE})
  if(NOT ARG_PROGRAMS)
    carillon_install_library(${name})
  endif()
endfunction()

# carillon_join_sources(TARGET [SOURCE ...]): all but the named sources are compiled eight at a time
# with -DCARILLON_JOIN_SOURCES=ON, which halves a build from nothing and lengthens the next ones a
# little.
function(carillon_join_sources target)
  if(NOT CARILLON_JOIN_SOURCES)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# carillon_targets(RESULT WORD ...): the words, where they are folders of the source by the targets of those.
function(carillon_targets result)
  set(targets)
  foreach(word IN LISTS ARGN)
    if(word MATCHES "^[a-z_/]+$" AND IS_DIRECTORY ${PROJECT_SOURCE_DIR}/${word})
      string(REPLACE / _ word carillon_${word})
    endif()
    list(APPEND targets ${word})
  endforeach()
  set(${result} ${targets} PARENT_SCOPE)
endfunction()

# carillon_link(TARGET PUBLIC|PRIVATE|INTERFACE WORD ...): folders among the words mean their libraries.
function(carillon_link target how)
  carillon_targets(libraries ${ARGN})
  target_link_libraries(${target} ${how} ${libraries})
endfunction()

# carillon_folder(FOLDER [FOLDERS ...] [EXCEPT ...] LINK ... [PRIVATE_LINK ...] [KERNELS] [ALONE ...]
#                 [OWN_OPTIONS] [PROGRAMS]): the library of a folder, carillon_ and its name with _ for /,
# from the sources in it and in its detail/; FOLDERS: and in those below it; EXCEPT: but for these. LINK
# names other folders, or targets. The rest as for carillon_library.
function(carillon_folder folder)
  cmake_parse_arguments(ARG "KERNELS;OWN_OPTIONS;PROGRAMS" "" "FOLDERS;EXCEPT;LINK;PRIVATE_LINK;ALONE" ${ARGN})
  set(patterns *.cpp detail/*.cpp)
  foreach(below ${ARG_FOLDERS})
    list(APPEND patterns ${below}/*.cpp ${below}/detail/*.cpp)
  endforeach()
  list(TRANSFORM patterns PREPEND ${PROJECT_SOURCE_DIR}/${folder}/)
  file(GLOB sources CONFIGURE_DEPENDS ${patterns})
  list(TRANSFORM ARG_EXCEPT PREPEND ${PROJECT_SOURCE_DIR}/${folder}/)
  list(REMOVE_ITEM sources ${ARG_EXCEPT})
  list(TRANSFORM ARG_ALONE PREPEND ${PROJECT_SOURCE_DIR}/${folder}/)
  carillon_targets(libraries ${ARG_LINK})
  string(REPLACE / _ name carillon_${folder})
  set(flags)
  foreach(flag KERNELS OWN_OPTIONS PROGRAMS)
    if(ARG_${flag})
      list(APPEND flags ${flag})
    endif()
  endforeach()
  if(NOT ARG_PROGRAMS)
    carillon_install_headers(${folder})
  endif()
  carillon_library(${name} SOURCES ${sources} LINK ${libraries} PRIVATE_LINK ${ARG_PRIVATE_LINK}
                   ALONE ${ARG_ALONE} ${flags})
endfunction()

# carillon_embed(FOLDER FILE NAMESPACE NAME): a text file of the repository within the library of a folder, as
# the std::string_view NAMESPACE::NAME that its sources declare. Nothing is looked for when a program runs.
function(carillon_embed folder file namespace name)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${file})
  file(READ ${PROJECT_SOURCE_DIR}/${file} text)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/shared_text.cpp.in ${source} @ONLY)
  set_source_files_properties(${source} PROPERTIES SKIP_PRECOMPILE_HEADERS ON SKIP_UNITY_BUILD_INCLUSION ON)
  carillon_targets(library ${folder})
  target_sources(${library} PRIVATE ${source})
endfunction()
