# Headers that most sources read, compiled once for each kind of target: kernels (optimised in full),
# rest, and tests, with what those read. carillon_precompile(TARGET KIND) makes TARGET use them; off
# with -DCARILLON_PRECOMPILED=OFF. The header check compiles every header without them.
option(CARILLON_PRECOMPILED "Compile common headers once" ON)

# ccache keeps what was made with them where they do not say when they were made.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  set(CARILLON_PRECOMPILED_OPTIONS -fpch-preprocess)
else()
  set(CARILLON_PRECOMPILED_OPTIONS "SHELL:-Xclang -fno-pch-timestamp")
endif()

set(CARILLON_COMMON_HEADERS
  <algorithm> <array> <chrono> <cmath> <complex> <cstdint> <filesystem> <fstream> <functional> <limits>
  <map> <memory> <mutex> <numbers> <numeric> <optional> <set> <span> <sstream> <stdexcept> <string>
  <string_view> <thread> <tuple> <utility> <variant> <vector>
  <Eigen/Dense> <fmt/format.h> <fmt/ranges.h> <nlohmann/json.hpp>)

function(carillon_precompile target kind)
  if(NOT CARILLON_PRECOMPILED)
    return()
  endif()
  set(source carillon_precompiled_${kind})
  if(NOT TARGET ${source})
    set(headers ${CARILLON_COMMON_HEADERS})
    set(link carillon_options Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
    if(kind STREQUAL tests)
      list(APPEND headers <gtest/gtest.h> <rapidcheck.h> <rapidcheck/gtest.h>)
      list(APPEND link GTest::gtest rapidcheck)
    endif()
    set(empty ${PROJECT_BINARY_DIR}/${source}.cpp)
    file(CONFIGURE OUTPUT ${empty} CONTENT "// Only the headers that are compiled with it.\n")
    add_library(${source} OBJECT ${empty})
    target_link_libraries(${source} PRIVATE ${link})
    target_precompile_headers(${source} PRIVATE ${headers})
    target_compile_options(${source} PRIVATE ${CARILLON_PRECOMPILED_OPTIONS})
    if(NOT kind STREQUAL kernels)
      target_compile_options(${source} PRIVATE ${CARILLON_REST_OPTIONS})
    endif()
  endif()
  target_precompile_headers(${target} REUSE_FROM ${source})
  target_compile_options(${target} PRIVATE ${CARILLON_PRECOMPILED_OPTIONS})
endfunction()
