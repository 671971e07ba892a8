#ifdef CARILLON_RTMIDI
#include <RtMidi.h>
#endif

#include <fmt/format.h>

#include <functional>

#include "cli/play/devices.hpp"
#include "core/error.hpp"

namespace carillon::cli::play {

#ifdef CARILLON_RTMIDI

namespace {

class MidiPort : public Opened {
 public:
  MidiPort(const std::string& name, std::function<void(const std::vector<unsigned char>&)> take)
      : take_(std::move(take)) {
    const unsigned count = input_.getPortCount();
    unsigned port = count;
    for (unsigned i = count; i-- > 0;) {
      if (input_.getPortName(i).find(name) != std::string::npos) port = i;
    }
    for (unsigned i = 0; i < count; ++i) {
      if (name == std::to_string(i)) port = i;
    }
    if (port == count) {
      throw core::InputError(fmt::format("there is no MIDI port \"{}\"", name),
                             "carillon play --midi list names them");
    }
    input_.setCallback(
        [](double, std::vector<unsigned char>* message, void* user) {
          auto& self = *static_cast<MidiPort*>(user);
          if (message != nullptr) self.take_(*message);
        },
        this);
    input_.openPort(port, "carillon play");
  }

 private:
  std::function<void(const std::vector<unsigned char>&)> take_;
  RtMidiIn input_;
};

/// What RtMidi throws, in the words of this program.
template <class Work>
auto with_midi(Work work) {
  try {
    return work();
  } catch (const RtMidiError& error) {
    throw core::InputError(fmt::format("MIDI: {}", error.getMessage()),
                           "is there a sound system (ALSA: /dev/snd/seq)?");
  }
}

}  // namespace

std::vector<std::string> midi_ports() {
  return with_midi([] {
    RtMidiIn input;
    std::vector<std::string> lines;
    for (unsigned i = 0; i < input.getPortCount(); ++i) {
      lines.push_back(fmt::format("{}: {}", i, input.getPortName(i)));
    }
    if (lines.empty()) throw core::InputError("there is no MIDI input", "connect one");
    return lines;
  });
}

std::unique_ptr<Opened> open_midi_port(
    const std::string& port, std::function<void(const std::vector<unsigned char>&)> take) {
  return with_midi([&]() -> std::unique_ptr<Opened> {
    return std::make_unique<MidiPort>(port, std::move(take));
  });
}

#else

std::vector<std::string> midi_ports() {
  throw core::InputError("MIDI needs RtMidi, which was missing when this was built",
                         "install librtmidi-dev and build again");
}

std::unique_ptr<Opened> open_midi_port(const std::string&,
                                       std::function<void(const std::vector<unsigned char>&)>) {
  midi_ports();
  return nullptr;
}

#endif

}  // namespace carillon::cli::play
