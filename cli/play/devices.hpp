#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cli/play/output.hpp"

namespace carillon::cli::play {

/// What holds a device or a port open; it goes with its owner.
class Opened {
 public:
  Opened() = default;
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;
  virtual ~Opened() = default;
  std::atomic<std::uint64_t> refused = 0;  ///< dropouts of sound devices, messages of inputs
  double latency = 0;                      ///< of sound devices, by their own word [s]
};

/// The sound devices that have outputs, a line each.
/// @throws InputError  there is none, or the program was built without PortAudio
std::vector<std::string> sound_devices();

/// Plays on a sound device from now on, in the device's own thread.
/// @param device  its number, part of its name, or "default"
/// @throws InputError  as sound_devices(), or it does not take the rate or the channels
std::unique_ptr<Opened> open_sound_device(synth::live::Player& player, const std::string& device,
                                          const Pace& pace);

/// The same of MIDI inputs (RtMidi).
std::vector<std::string> midi_ports();

/// Hands each message of a MIDI port to `take` as its bytes.
/// @throws InputError  no such port, or the program was built without RtMidi
std::unique_ptr<Opened> open_midi_port(const std::string& port,
                                       std::function<void(const std::vector<unsigned char>&)> take);

/// Takes OSC messages by UDP: /strike, /support, /damp and /stop (docs/play.md). Packets that are
/// malformed or cannot be are counted.
/// @param address  PORT (of loopback) or HOST:PORT
/// @throws InputError  it cannot be listened to, or the program was built without liblo
std::unique_ptr<Opened> open_osc(const std::string& address, Apply apply);

}  // namespace carillon::cli::play
