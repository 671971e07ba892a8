# Copies the headers in `folders` from the source tree `from` to the folder `to`. There they include each
# other as "carillon/core/...": names such as core/ and mpi/ would meet those of others.
foreach(folder IN LISTS folders)
  file(GLOB headers RELATIVE ${from} ${from}/${folder}/*.hpp)
  foreach(header IN LISTS headers)
    file(READ ${from}/${header} text)
    # Of the headers in quotes all are the project's: those of others are in angle brackets.
    string(REPLACE "#include \"" "#include \"carillon/" text "${text}")
    file(WRITE ${to}/${header} "${text}")
    list(APPEND CMAKE_INSTALL_MANIFEST_FILES ${to}/${header})
  endforeach()
endforeach()
