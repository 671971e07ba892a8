# Copies the doors of the library from the source tree `from` to the folder `to`. There they include each
# other as "carillon/core/...": names such as core/ and mpi/ would meet those of others.
set(rooms core mpi solvers render synth scene dataset eval report)
list(JOIN rooms "|" any_room)
foreach(room IN LISTS rooms)
  file(GLOB_RECURSE headers RELATIVE ${from} ${from}/${room}/*.hpp)
  foreach(header IN LISTS headers)
    # What is within a folder's detail/ is its own; what needs libtorch is for programs alone.
    if(header MATCHES "/detail/|^eval/(networks|recognition|studies/learning)/|^solvers/mesher/worker/")
      continue()
    endif()
    file(READ ${from}/${header} text)
    string(REGEX REPLACE "#include \"((${any_room})/)" "#include \"carillon/\\1" text "${text}")
    file(WRITE ${to}/${header} "${text}")
    list(APPEND CMAKE_INSTALL_MANIFEST_FILES ${to}/${header})
  endforeach()
endforeach()
