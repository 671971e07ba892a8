# Manual page and completion, written by the program when it is installed.
set(carillon_reference
  "manual COMMAND gzip -9n|man/man1|carillon.1.gz"
  "completion bash|bash-completion/completions|carillon"
  "completion fish|fish/vendor_completions.d|carillon.fish")
foreach(entry IN LISTS carillon_reference)
  string(REPLACE "|" ";" entry "${entry}")
  list(GET entry 0 words)
  list(GET entry 1 folder)
  list(GET entry 2 file)
  install(CODE "
    set(folder \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/${folder}\")
    file(MAKE_DIRECTORY \"\${folder}\")
    execute_process(COMMAND $<TARGET_FILE:carillon> ${words}
                    OUTPUT_FILE \"\${folder}/${file}\" COMMAND_ERROR_IS_FATAL ANY)")
endforeach()
