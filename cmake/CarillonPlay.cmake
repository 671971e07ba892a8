# Devices of `carillon play`: sound by PortAudio, MIDI by RtMidi, OSC by liblo. Each is used where it is there;
# without it its option says so.
carillon_folder(cli/play PROGRAMS LINK scene/live ALONE sound_device.cpp midi_port.cpp osc_port.cpp)
foreach(device "PORTAUDIO portaudio-2.0" "RTMIDI rtmidi" "LIBLO liblo")
  separate_arguments(device)
  list(GET device 0 name)
  list(GET device 1 package)
  pkg_check_modules(${name} QUIET ${package})
  if(${name}_FOUND)
    # Without their -pthread, which what is compiled beforehand is without.
    target_include_directories(carillon_cli_play SYSTEM PRIVATE ${${name}_INCLUDE_DIRS})
    target_link_libraries(carillon_cli_play PRIVATE ${${name}_LINK_LIBRARIES})
    target_compile_definitions(carillon_cli_play PRIVATE CARILLON_${name})
  else()
    message(STATUS "${package} was not found: carillon play goes without")
  endif()
endforeach()
