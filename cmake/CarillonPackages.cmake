# Debian packages by CPack, one for each component: scripts/packaging/debs makes them. What only they
# hold (copyright, changelog, documentation) is not installed by hand.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME carillon)
set(CPACK_PACKAGE_CONTACT "The Carillon developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own
carillon_revision(CPACK_PACKAGE_VERSION ${PROJECT_SOURCE_DIR} ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# carillon_package(NAME DESCRIPTION): the package of the component NAME.
set(CPACK_COMPONENTS_ALL)
macro(carillon_package name description)
  list(APPEND CPACK_COMPONENTS_ALL ${name})
  string(TOUPPER ${name} component)
  set(CPACK_DEBIAN_${component}_PACKAGE_NAME ${name})
  set(CPACK_COMPONENT_${component}_DESCRIPTION "${description}")
  set(folder ${CMAKE_INSTALL_DATADIR}/doc/${name})
  install(FILES cmake/copyright DESTINATION ${folder} COMPONENT ${name} EXCLUDE_FROM_ALL)
  install(CODE "
    execute_process(COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md COMMAND_ERROR_IS_FATAL ANY
      OUTPUT_FILE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${folder}/changelog.gz\")"
    COMPONENT ${name} EXCLUDE_FROM_ALL)
endmacro()

carillon_package(carillon
"datasets of struck objects: modes, sounds and pictures
Turns shapes, materials and scenes into labelled datasets of struck objects:
the modes of each object by finite elements, the sounds of strikes on it, its
voxels and its picture, in HDF5, on one core or on many MPI ranks.")
set(CPACK_DEBIAN_CARILLON_PACKAGE_SECTION science)
# The launcher of its ranks, and a BLAS of one thread a rank.
set(CPACK_DEBIAN_CARILLON_PACKAGE_DEPENDS "openmpi-bin, libopenblas0-serial")
if(CARILLON_OFFSCREEN_FOUND STREQUAL egl)
  string(APPEND CPACK_DEBIAN_CARILLON_PACKAGE_DEPENDS ", libgl1-mesa-dri") # which EGL loads by itself
endif()
# Pictures beside its results, and movies.
set(CPACK_DEBIAN_CARILLON_PACKAGE_RECOMMENDS "python3, python3-matplotlib, python3-numpy, python3-h5py")
set(CPACK_DEBIAN_CARILLON_PACKAGE_SUGGESTS "carillon-learn, carillon-doc, ffmpeg")

if(CARILLON_PAGE)
  install(FILES ${PROJECT_BINARY_DIR}/report-page/licences.txt DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/carillon
          COMPONENT carillon EXCLUDE_FROM_ALL)
endif()

carillon_package(carillon-dev
"library of carillon: modes and sounds of struck objects in C++
Headers, archives and the CMake configuration of what the program carillon is
made of: meshes, finite elements, synthesis, datasets and their evaluation.")
set(CPACK_DEBIAN_CARILLON-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_CARILLON-DEV_PACKAGE_SHLIBDEPS OFF)
# Those that the program is built from.
file(READ scripts/setup development)
string(REGEX REPLACE "\npart learn .*" "" development "${development}")
if(CARILLON_OFFSCREEN_FOUND STREQUAL egl)
  string(REGEX REPLACE "'[^|']*[|]" "'" development "${development}")
else()
  string(REGEX REPLACE "[|][^']*'" "'" development "${development}")
endif()
string(REGEX MATCHALL "[a-z0-9.+-]+-dev" development "${development}")
list(JOIN development ", " development)
set(CPACK_DEBIAN_CARILLON-DEV_PACKAGE_DEPENDS "carillon (= ${CPACK_PACKAGE_VERSION}), ${development}")
install(DIRECTORY examples/cpp/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/carillon-dev/examples
        COMPONENT carillon-dev)

if(CARILLON_LEARN)
  carillon_package(carillon-learn
"classifiers for datasets of struck objects
Trains networks and other classifiers on the datasets that carillon makes,
evaluates them, and tells shape and material of a recorded sound. Adds the
commands train and identify, and sections of evaluate, to carillon.")
  set(CPACK_DEBIAN_CARILLON-LEARN_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_CARILLON-LEARN_PACKAGE_DEPENDS "carillon (= ${CPACK_PACKAGE_VERSION})")
endif()

if(CARILLON_PYTHON)
  carillon_package(python3-carillon
"Python module of carillon
Modes and sounds of struck objects, their features and damping, with arrays of
NumPy in and out; datasets of them for NumPy and PyTorch.")
  set(CPACK_DEBIAN_PYTHON3-CARILLON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON3-CARILLON_PACKAGE_DEPENDS
      "carillon (= ${CPACK_PACKAGE_VERSION}), python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON3-CARILLON_PACKAGE_SUGGESTS "python3-torch, python3-matplotlib, python3-pandas")
endif()

carillon_package(carillon-doc
"documentation of carillon
How datasets of struck objects are made with carillon, what their files hold,
what is computed and how well, and job scripts for clusters.")
set(CPACK_DEBIAN_CARILLON-DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_CARILLON-DOC_PACKAGE_ARCHITECTURE all)
# As in the repository, so that links hold.
install(FILES README.md CONTRIBUTING.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/carillon-doc
        COMPONENT carillon-doc EXCLUDE_FROM_ALL)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/carillon-doc
        COMPONENT carillon-doc EXCLUDE_FROM_ALL)
install(DIRECTORY scripts/slurm DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/carillon-doc/scripts
        COMPONENT carillon-doc EXCLUDE_FROM_ALL USE_SOURCE_PERMISSIONS)

include(CPack)
