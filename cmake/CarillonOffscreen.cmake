# What pictures are drawn with, as the target carillon_offscreen: OSMesa, or Mesa's EGL without a surface.
# Sets CARILLON_OFFSCREEN_FOUND to osmesa, egl or, with -DCARILLON_RENDER=OFF, none.
option(CARILLON_RENDER "Draw pictures, which needs OpenGL" ON)
set(CARILLON_OFFSCREEN auto CACHE STRING "What pictures are drawn with: osmesa, egl, or auto for the first that is there")
set_property(CACHE CARILLON_OFFSCREEN PROPERTY STRINGS auto osmesa egl)
if(NOT CARILLON_OFFSCREEN MATCHES "^(auto|osmesa|egl|none)$")
  message(FATAL_ERROR "CARILLON_OFFSCREEN=${CARILLON_OFFSCREEN}: osmesa, egl or auto")
endif()

add_library(carillon_offscreen INTERFACE IMPORTED GLOBAL)
set(CARILLON_OFFSCREEN_FOUND none)
if(CARILLON_RENDER AND CARILLON_OFFSCREEN MATCHES "auto|osmesa")
  pkg_check_modules(OSMESA QUIET IMPORTED_TARGET GLOBAL osmesa)
  if(OSMESA_FOUND)
    set(CARILLON_OFFSCREEN_FOUND osmesa)
    target_link_libraries(carillon_offscreen INTERFACE PkgConfig::OSMESA)
  endif()
endif()
if(CARILLON_RENDER AND CARILLON_OFFSCREEN MATCHES "auto|egl" AND CARILLON_OFFSCREEN_FOUND STREQUAL none)
  find_package(OpenGL QUIET COMPONENTS OpenGL EGL)
  if(OpenGL_OpenGL_FOUND AND OpenGL_EGL_FOUND)
    set(CARILLON_OFFSCREEN_FOUND egl)
    target_link_libraries(carillon_offscreen INTERFACE OpenGL::EGL OpenGL::OpenGL)
  endif()
endif()
if(CARILLON_RENDER AND NOT CARILLON_OFFSCREEN STREQUAL none AND CARILLON_OFFSCREEN_FOUND STREQUAL none)
  message(FATAL_ERROR "Pictures cannot be drawn (CARILLON_OFFSCREEN=${CARILLON_OFFSCREEN}): OSMesa "
    "(osmesa.pc; Debian: libosmesa6-dev) or EGL with OpenGL (Debian: libegl-dev and libopengl-dev) is "
    "missing. Add the folder that it is installed under to CMAKE_PREFIX_PATH, or build without pictures "
    "by -DCARILLON_RENDER=OFF. ${CARILLON_FIND_HELP}")
endif()
