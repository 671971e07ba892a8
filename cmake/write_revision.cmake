# Writes OUTPUT, a header with the commit of SOURCE: REVISION where given, else what git says, else "".
if(NOT REVISION AND GIT AND EXISTS ${SOURCE}/.git)
  execute_process(
    COMMAND ${GIT} --git-dir=${SOURCE}/.git --work-tree=${SOURCE} describe --always --dirty --tags
    OUTPUT_VARIABLE REVISION OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
set(text "#define CARILLON_REVISION \"${REVISION}\"\n")
set(before)
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} before)
endif()
if(NOT text STREQUAL before)
  file(WRITE ${OUTPUT} "${text}")
endif()
