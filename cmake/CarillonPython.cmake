# The Python module: by default where Python's headers and pybind11 are. Not with sanitizers, with which Python itself
# would have to be built.
# -DPython_EXECUTABLE=... names another one than the system's.
find_program(Python_EXECUTABLE NAMES python3 HINTS /usr/bin)
find_package(Python 3.10 QUIET COMPONENTS Interpreter Development.Module)
find_package(pybind11 2.9 QUIET CONFIG)
if(Python_Development.Module_FOUND AND pybind11_FOUND AND NOT CARILLON_SANITIZE)
  set(CARILLON_PYTHON_FOUND ON)
else()
  set(CARILLON_PYTHON_FOUND OFF)
endif()
option(CARILLON_PYTHON "Build the Python module" ${CARILLON_PYTHON_FOUND})
if(CARILLON_PYTHON AND NOT CARILLON_PYTHON_FOUND)
  message(FATAL_ERROR "Python's headers or pybind11 are missing. Debian: ./scripts/setup installs them. "
    "Elsewhere: set Python_ROOT_DIR and pybind11_DIR, or leave the module out with -DCARILLON_PYTHON=OFF.")
endif()
