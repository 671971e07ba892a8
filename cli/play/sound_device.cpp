#ifdef CARILLON_PORTAUDIO
#include <fcntl.h>
#include <portaudio.h>
#include <unistd.h>
#endif

#include <fmt/format.h>

#include <algorithm>

#include "cli/play/devices.hpp"
#include "core/error.hpp"

namespace carillon::cli::play {

#ifdef CARILLON_PORTAUDIO

namespace {

constexpr const char* no_device_remedy =
    "write the samples to a pipe: carillon play ... -o - | aplay -f FLOAT_LE -r 44100 -c 1";

void check_portaudio(PaError error, const char* what) {
  if (error >= 0) return;
  throw core::InputError(fmt::format("{}: {}", what, Pa_GetErrorText(error)), no_device_remedy);
}

/// While it lives, standard error goes nowhere: ALSA and JACK tell there of every device that they
/// look for and that is not there.
class QuietErrors {
 public:
  QuietErrors() : kept_(::dup(STDERR_FILENO)) {
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (nowhere < 0) return;
    ::dup2(nowhere, STDERR_FILENO);
    ::close(nowhere);
  }
  ~QuietErrors() {
    if (kept_ < 0) return;
    ::dup2(kept_, STDERR_FILENO);
    ::close(kept_);
  }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  int kept_;
};

PaError start_portaudio() {
  const QuietErrors quiet;
  return Pa_Initialize();
}

/// PortAudio, started.
struct PortAudio {
  PortAudio() { check_portaudio(start_portaudio(), "PortAudio does not start"); }
  ~PortAudio() { Pa_Terminate(); }
  PortAudio(const PortAudio&) = delete;
  PortAudio& operator=(const PortAudio&) = delete;
};

/// Those with outputs.
std::vector<PaDeviceIndex> outputs() {
  std::vector<PaDeviceIndex> found;
  for (PaDeviceIndex i = 0; i < Pa_GetDeviceCount(); ++i) {
    if (Pa_GetDeviceInfo(i)->maxOutputChannels > 0) found.push_back(i);
  }
  if (found.empty()) throw core::InputError("there is no sound device", no_device_remedy);
  return found;
}

PaDeviceIndex find_device(const std::string& name) {
  const std::vector<PaDeviceIndex> all = outputs();
  if (name == "default") {
    const PaDeviceIndex usual = Pa_GetDefaultOutputDevice();
    return usual == paNoDevice ? all.front() : usual;
  }
  for (const PaDeviceIndex i : all) {
    if (name == std::to_string(i)) return i;
  }
  for (const PaDeviceIndex i : all) {
    if (std::string(Pa_GetDeviceInfo(i)->name).find(name) != std::string::npos) return i;
  }
  throw core::InputError(fmt::format("there is no sound device \"{}\"", name),
                         "carillon play --device list names them");
}

class SoundDevice : public Opened {
 public:
  SoundDevice(synth::live::Player& player, const std::string& name, const Pace& pace)
      : player_(player) {
    PaStreamParameters parameters{};
    parameters.device = find_device(name);
    parameters.channelCount = static_cast<int>(player.rows());
    parameters.sampleFormat = paFloat32;
    parameters.suggestedLatency = pace.latency;
    check_portaudio(Pa_OpenStream(&stream_, nullptr, &parameters, player.sample_rate(), pace.block,
                                  paNoFlag, callback, this),
                    "the sound device cannot be opened");
    if (const PaStreamInfo* info = Pa_GetStreamInfo(stream_)) latency = info->outputLatency;
    const PaError error = Pa_StartStream(stream_);
    if (error < 0) Pa_CloseStream(stream_);
    check_portaudio(error, "the sound device does not start");
  }
  ~SoundDevice() override { Pa_CloseStream(stream_); }
  SoundDevice(const SoundDevice&) = delete;
  SoundDevice& operator=(const SoundDevice&) = delete;

 private:
  /// The device's thread: it neither allocates nor locks nor waits, as Player::play() does not.
  static int callback(const void*, void* output, unsigned long frames,
                      const PaStreamCallbackTimeInfo*, PaStreamCallbackFlags flags, void* user) {
    auto& device = *static_cast<SoundDevice*>(user);
    if ((flags & paOutputUnderflow) != 0) ++device.refused;
    device.player_.play({static_cast<float*>(output), frames * device.player_.rows()});
    return paContinue;
  }

  PortAudio started_;
  synth::live::Player& player_;
  PaStream* stream_ = nullptr;
};

}  // namespace

std::vector<std::string> sound_devices() {
  const PortAudio started;
  std::vector<std::string> lines;
  for (const PaDeviceIndex i : outputs()) {
    const PaDeviceInfo& info = *Pa_GetDeviceInfo(i);
    lines.push_back(fmt::format("{}: {} ({} channels, {} Hz){}", i, info.name,
                                info.maxOutputChannels, info.defaultSampleRate,
                                i == Pa_GetDefaultOutputDevice() ? ", the default" : ""));
  }
  return lines;
}

std::unique_ptr<Opened> open_sound_device(synth::live::Player& player, const std::string& device,
                                          const Pace& pace) {
  return std::make_unique<SoundDevice>(player, device, pace);
}

#else

std::vector<std::string> sound_devices() {
  throw core::InputError("sound devices need PortAudio, which was missing when this was built",
                         "install portaudio19-dev and build again, or play to a pipe with -o -");
}

std::unique_ptr<Opened> open_sound_device(synth::live::Player&, const std::string&, const Pace&) {
  sound_devices();
  return nullptr;
}

#endif

}  // namespace carillon::cli::play
