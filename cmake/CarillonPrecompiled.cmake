# Headers that most sources read, compiled once for the libraries and once, with what tests read, for
# the tests. carillon_precompile(TARGET [TESTS]) makes TARGET use them; off with
# -DCARILLON_PRECOMPILED=OFF. The header check compiles every header without them.
option(CARILLON_PRECOMPILED "Compile common headers once" ON)

set(CARILLON_COMMON_HEADERS
  <algorithm> <array> <chrono> <cmath> <complex> <cstdint> <filesystem> <fstream> <functional> <limits>
  <map> <memory> <mutex> <numbers> <numeric> <optional> <set> <span> <sstream> <stdexcept> <string>
  <string_view> <thread> <tuple> <utility> <variant> <vector>
  <Eigen/Dense> <fmt/format.h> <fmt/ranges.h> <nlohmann/json.hpp>)

function(carillon_precompile target)
  cmake_parse_arguments(ARG "TESTS" "" "" ${ARGN})
  if(NOT CARILLON_PRECOMPILED)
    return()
  endif()
  set(source carillon_precompiled)
  set(headers ${CARILLON_COMMON_HEADERS})
  set(link carillon_options Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
  if(ARG_TESTS)
    set(source carillon_tests_precompiled)
    list(APPEND headers <gtest/gtest.h> <rapidcheck.h> <rapidcheck/gtest.h>)
    list(APPEND link GTest::gtest rapidcheck)
  endif()
  if(NOT TARGET ${source})
    set(empty ${PROJECT_BINARY_DIR}/${source}.cpp)
    file(CONFIGURE OUTPUT ${empty} CONTENT "// Only the headers that are compiled with it.\n")
    add_library(${source} OBJECT ${empty})
    target_link_libraries(${source} PRIVATE ${link})
    target_precompile_headers(${source} PRIVATE ${headers})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${source})
endfunction()
