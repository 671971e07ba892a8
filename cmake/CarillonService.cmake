# The server of `carillon serve`, by cpp-httplib. Without it, or with -DCARILLON_SERVE=OFF, the program has no such
# command. For the programs alone: others that use the library bring their own.
option(CARILLON_SERVE "carillon serve, which needs cpp-httplib" ON)
if(NOT CARILLON_SERVE)
  return()
endif()
pkg_check_modules(HTTPLIB QUIET IMPORTED_TARGET GLOBAL cpp-httplib)
if(NOT HTTPLIB_FOUND)
  message(STATUS "cpp-httplib was not found: there is no carillon serve")
  return()
endif()
carillon_folder(report/service FOLDERS jobs PROGRAMS LINK report dataset/exporters dataset/regenerate eval/damping eval/perception PRIVATE_LINK PkgConfig::HTTPLIB
                ALONE http_server.cpp detail/timed_stream.cpp)
carillon_embed(report/service share/carillon/openapi.json carillon::report::service openapi_json)
set(CARILLON_SERVICE ON PARENT_SCOPE)
