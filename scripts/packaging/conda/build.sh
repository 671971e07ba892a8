#!/usr/bin/env bash
# What `conda build` runs, in the folder of the source.
set -euo pipefail
# shellcheck disable=SC2086  # CMAKE_ARGS are words
cmake ${CMAKE_ARGS:-} -G Ninja -S . -B build-conda -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$PREFIX" \
  -DPETSC_DIR="$PREFIX" -DSLEPC_DIR="$PREFIX" -DPETSC_ARCH= -DHDF5_ROOT="$PREFIX" \
  -DPython_EXECUTABLE="$PYTHON" -DCARILLON_PYTHON_DIR="${SP_DIR#"$PREFIX"/}" \
  -DCARILLON_OFFSCREEN=egl -DCARILLON_REPORT=OFF -DCARILLON_LEARN="${CARILLON_LEARN:-OFF}" \
  -DCARILLON_JOIN_SOURCES=ON
cmake --build build-conda --parallel "${CPU_COUNT:-2}"
cmake --install build-conda --prefix "$PREFIX"
