# Debian packages, made by scripts/packaging/debs: carillon, carillon-learn (classifiers; libtorch) and
# carillon-doc. What they depend on dpkg-shlibdeps finds, but for what is run or loaded at run time.
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT doc)
install(FILES README.md CHANGELOG.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT doc)
foreach(component program learn doc)
  set(package carillon-${component})
  if(component STREQUAL program)
    set(package carillon)
  endif()
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  install(FILES scripts/packaging/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package}
          COMPONENT ${component})
endforeach()

if(CARILLON_PAGE)
  install(FILES ${PROJECT_BINARY_DIR}/report-page/licences.txt
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/carillon COMPONENT program)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL program doc)
if(CARILLON_LEARN)
  list(APPEND CPACK_COMPONENTS_ALL learn)
endif()
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_CONTACT "The Carillon developers")
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 0)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
  "Modes of bodies by finite elements, impact sounds, voxels, pictures and touch
as HDF5 datasets, on one core or on many MPI ranks; damping and materials
found again in sounds.")
# mpirun; a BLAS of one thread (the reference BLAS is many times slower).
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "openmpi-bin, libopenblas0-serial | libopenblas0")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "python3-h5py, python3-matplotlib")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "carillon-learn, carillon-doc")

set(CPACK_COMPONENT_LEARN_DESCRIPTION "Classifiers of sounds, voxels, pictures and touch:
what carillon train, evaluate and identify run.")
set(CPACK_DEBIAN_LEARN_PACKAGE_DEPENDS "carillon (= ${PROJECT_VERSION})")

set(CPACK_COMPONENT_DOC_DESCRIPTION "Documentation: guide, every key of a configuration,
methods, file formats, loaders to copy.")
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOC_PACKAGE_SHLIBDEPS OFF)
include(CPack)
