# What `cmake --install` installs of the library: the doors of its folders, as <carillon/...>, its
# archives, and what find_package(carillon) reads. All of it is the component carillon-dev.
set(CARILLON_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/carillon)

# carillon_install_library(NAME): the target carillon::NAME, without the carillon_ that it begins with.
function(carillon_install_library name)
  string(REGEX REPLACE "^carillon_" "" export_name ${name})
  set_target_properties(${name} PROPERTIES EXPORT_NAME ${export_name})
  install(TARGETS ${name} EXPORT carillonTargets COMPONENT carillon-dev
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/carillon)
  set_property(GLOBAL APPEND PROPERTY CARILLON_INSTALLED_LIBRARIES ${name})
endfunction()

# carillon_install_headers(FOLDER ...): the headers in these, which are their doors.
function(carillon_install_headers)
  set_property(GLOBAL APPEND PROPERTY CARILLON_INSTALLED_FOLDERS ${ARGN})
endfunction()

# After all folders: carillon::carillon, which is every library at once, the headers and the configuration.
function(carillon_install_config)
  get_property(libraries GLOBAL PROPERTY CARILLON_INSTALLED_LIBRARIES)
  add_library(carillon_all INTERFACE)
  target_link_libraries(carillon_all INTERFACE ${libraries})
  set_target_properties(carillon_all PROPERTIES EXPORT_NAME carillon)
  set_target_properties(carillon_interface PROPERTIES EXPORT_NAME interface)
  install(TARGETS carillon_all carillon_interface EXPORT carillonTargets COMPONENT carillon-dev)
  install(EXPORT carillonTargets NAMESPACE carillon:: DESTINATION ${CARILLON_CMAKE_DIR}
          COMPONENT carillon-dev)

  include(CMakePackageConfigHelpers)
  configure_package_config_file(cmake/carillonConfig.cmake.in ${PROJECT_BINARY_DIR}/carillonConfig.cmake
                                INSTALL_DESTINATION ${CARILLON_CMAKE_DIR})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/carillonConfigVersion.cmake
                                   COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/carillonConfig.cmake ${PROJECT_BINARY_DIR}/carillonConfigVersion.cmake
                cmake/CarillonDependencies.cmake cmake/CarillonFind.cmake cmake/CarillonPetsc.cmake
                cmake/CarillonHdf5.cmake cmake/CarillonOffscreen.cmake
          DESTINATION ${CARILLON_CMAKE_DIR} COMPONENT carillon-dev)
  get_property(folders GLOBAL PROPERTY CARILLON_INSTALLED_FOLDERS)
  install(CODE "
    set(folders ${folders})
    set(from ${PROJECT_SOURCE_DIR})
    set(to \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/include/carillon\")
    include(${PROJECT_SOURCE_DIR}/cmake/InstallHeaders.cmake)" COMPONENT carillon-dev)
endfunction()
