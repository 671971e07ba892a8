# The page of `carillon report`: bundled by npm and esbuild, and put into the program. Without npm, or
# with -DCARILLON_REPORT=OFF, the command says that it has none.
option(CARILLON_REPORT "Bundle the page of reports, which needs npm and the network once" ON)
find_program(CARILLON_NPM npm)
find_program(CARILLON_NODE node)
if(NOT CARILLON_REPORT)
  return()
endif()
if(NOT CARILLON_NPM OR NOT CARILLON_NODE)
  message(STATUS "npm was not found: carillon report has no page")
  return()
endif()

set(page_source ${PROJECT_SOURCE_DIR}/report/page)
set(page_folder ${PROJECT_BINARY_DIR}/report-page)
set(page_packages ${page_folder}/node_modules/.package-lock.json)
set(page_frozen package.json package-lock.json .npmrc)
list(TRANSFORM page_frozen PREPEND ${page_source}/)
file(GLOB page_parts CONFIGURE_DEPENDS ${page_source}/src/*)

file(MAKE_DIRECTORY ${page_folder})

add_custom_command(OUTPUT ${page_packages}
  COMMAND ${CMAKE_COMMAND} -E copy ${page_frozen} ${page_folder}
  COMMAND ${CARILLON_NPM} ci --ignore-scripts --no-progress --loglevel=error
  COMMAND ${CMAKE_COMMAND} -E touch ${page_packages}
  WORKING_DIRECTORY ${page_folder}
  DEPENDS ${page_frozen}
  COMMENT "Fetching what the page of reports is made of (-DCARILLON_REPORT=OFF: none)")
add_custom_command(OUTPUT ${page_folder}/page.html BYPRODUCTS ${page_folder}/licences.txt ${page_folder}/page.html.hpp
  COMMAND ${CMAKE_COMMAND} -E copy ${page_source}/build.mjs ${page_folder}
  COMMAND ${CARILLON_NODE} build.mjs ${page_source}/src page.html
  WORKING_DIRECTORY ${page_folder}
  DEPENDS ${page_packages} ${page_source}/build.mjs ${page_parts}
  COMMENT "Bundling the page of reports")
set_source_files_properties(${PROJECT_SOURCE_DIR}/report/page.cpp PROPERTIES
  OBJECT_DEPENDS ${page_folder}/page.html
  COMPILE_DEFINITIONS "CARILLON_PAGE=\"${page_folder}/page.html\";CARILLON_PAGE_HASH=\"${page_folder}/page.html.hpp\"")
set(CARILLON_PAGE ON PARENT_SCOPE)
