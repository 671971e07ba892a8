#include "synth/contact/recorded_force.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/numbers.hpp"

namespace carillon::synth::contact {

namespace {

constexpr double longest_recording = 60;  // [s]

void check_length(double seconds) {
  if (seconds <= longest_recording) return;
  throw core::InputError(
      fmt::format("a force of {:.4g} s: at most {:.4g} s can strike", seconds, longest_recording),
      "cut it to its contacts");
}

}  // namespace

modal::ContactForce recorded_force(std::span<const double> newtons, double sample_rate) {
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw core::InputError(fmt::format("a force's sample rate is positive, not {}", sample_rate));
  }
  if (newtons.empty()) throw core::InputError("the force has no samples");
  check_length(static_cast<double>(newtons.size()) / sample_rate);
  modal::ContactForce force;
  if (newtons.front() != 0) force.samples.push_back(0);
  force.samples.insert(force.samples.end(), newtons.begin(), newtons.end());
  if (newtons.back() != 0 || force.samples.size() < 2) force.samples.push_back(0);
  force.duration = static_cast<double>(force.samples.size() - 1) / sample_rate;
  modal::check(force);
  if (core::peak(force.samples) == 0) {
    throw core::InputError("the force is 0 at all times: nothing would sound");
  }
  return force;
}

modal::ContactForce read_force(const std::filesystem::path& path, std::optional<double> peak) {
  try {
    // Before all of it is read: a header may promise hours.
    check_length(core::read_audio_header(path).seconds);
    const core::AudioClip clip = core::read_audio(path);
    if (clip.channels != 1) {
      throw core::InputError(fmt::format("{} channels, and a force has one", clip.channels),
                             "keep the hammer's channel: sox in.wav out.wav remix 1");
    }
    if (peak && !(*peak > 0 && std::isfinite(*peak))) {
      throw core::InputError("the largest force must be positive",
                             "leave it out for 1 N at full scale");
    }
    std::vector<double> newtons(clip.samples.begin(), clip.samples.end());
    const double loudest = core::peak(newtons);
    if (peak && loudest > 0) {
      for (double& value : newtons) value *= *peak / loudest;
    }
    return recorded_force(newtons, clip.sample_rate);
  } catch (const core::InputError& error) {
    throw core::InputError(fmt::format("{}: {}", path.string(), error.message()), error.hint());
  }
}

}  // namespace carillon::synth::contact
