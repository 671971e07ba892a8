#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <memory>

#include "scene/effects/detail/list.hpp"
#include "scene/room_scene.hpp"
#include "synth/recording/recording_file.hpp"
#include "synth/room/measured_responses.hpp"

namespace carillon::scene {

namespace {

// Measured by scripts/bench room: a convolution with 1 s, and the spectrum of a response.
constexpr double seconds_per_convolved_sample = 0.9e-3 / 44100;

struct MeasuredRoom {
  std::filesystem::path path;
  synth::room::MeasuredOptions options;
};

/// Spectra of responses for the last length of clips, up to room_memory of them.
class MeasuredSpectra {
 public:
  const synth::signal::ResponseSpectrum& of(const synth::room::MeasuredResponse& response,
                                            std::size_t clip) {
    const auto found = spectra_.find(&response);
    if (found != spectra_.end() && found->second.clip == clip) return found->second;
    if (static_cast<double>(bytes_) > room_memory) {
      spectra_.clear();
      bytes_ = 0;
    }
    const std::vector<double> samples(response.samples.begin(), response.samples.end());
    synth::signal::ResponseSpectrum spectrum = convolver_.prepare(samples, clip);
    bytes_ += spectrum.values.size() * sizeof(spectrum.values[0]);
    return spectra_.insert_or_assign(&response, std::move(spectrum)).first->second;
  }

  /// Puts what is heard in the room in the place of a sound.
  void convolve(const synth::room::MeasuredResponse& response, std::span<float> row) {
    const std::vector<float> before(row.begin(), row.end());
    std::fill(row.begin(), row.end(), 0.0F);
    convolver_.add(before, of(response, row.size()), row);
  }

 private:
  synth::signal::Convolver convolver_;
  std::map<const synth::room::MeasuredResponse*, synth::signal::ResponseSpectrum> spectra_;
  std::size_t bytes_ = 0;
};

MeasuredRoom read_measured(core::ConfigNode& node, const Scene& scene) {
  for (const char* key : {"dimensions", "source", "listener", "margin", "absorption", "walls",
                          "rt60", "image_order", "count", "temperature", "humidity"}) {
    if (!node.has(key)) continue;
    node.fail(key, "is of a room that is simulated, but `responses` are measured ones",
              "remove one of the two");
  }
  MeasuredRoom room;
  room.path = core::path_beside(scene.file_name, node.text("responses"));
  room.options.channel = static_cast<int>(node.integer("channel", 0, 1024, 0));
  room.options.sample_rate = scene.audio.sample_rate;
  room.options.count = scene.rendered_samples();
  room.options.parts = scene.parts;
  return room;
}

/// Reads the files, which every object's chain then has from there.
void check_responses(const MeasuredRoom& room) {
  const auto responses = synth::room::shared_responses(room.path, room.options);
  const auto& left_out = responses->left_out();
  if (left_out.empty()) return;
  spdlog::warn("room.responses: {} of the files in {} are not used; the first: {}", left_out.size(),
               room.path.string(), left_out.front());
}

EffectParts start(const MeasuredRoom& room) {
  const auto responses = synth::room::shared_responses(room.path, room.options);
  const auto spectra = std::make_shared<MeasuredSpectra>();
  EffectParts parts;
  parts.audio = [responses, spectra](Sound& sound) {
    core::RandomStream random(sound.seed, sound.id, "room.response");
    const synth::room::MeasuredResponse& response = responses->draw(sound.part, random);
    for (std::size_t r = 0; r < sound.rows; ++r) spectra->convolve(response, sound.row(r));
    if (sound.record == nullptr) return;
    sound.record->add("room_response", response.name);
    sound.record->add("room_response_channel", static_cast<std::int64_t>(response.channel));
  };
  return parts;
}

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect;
  if (!root.has("room") || !root.child("room").has("responses")) {
    effect.reason_off = "no room.responses:";
    return effect;
  }
  core::ConfigNode node = root.child("room");
  const bool dry = read_dry_input(node, scene);
  const MeasuredRoom room = read_measured(node, scene);
  effect.asked_by = asked_by_room("room.responses", node.where("responses"), dry);
  if (!dry) effect.reason_off = why_unheard(scene);
  const auto samples = static_cast<double>(scene.rendered_samples());
  const synth::room::MeasuredSize size = synth::room::measured_size(room.path, room.options);
  effect.seconds_per_sound = seconds_per_convolved_sample * samples;
  effect.memory = size.bytes + std::min(room_memory, spectrum_bytes * samples *
                                                         static_cast<double>(size.responses));
  effect.check = [node, room] { core::at_key(node, "responses", [&] { check_responses(room); }); };
  effect.content = [room] { return synth::recording::content_of_files(room.path); };
  effect.start = [room](const std::filesystem::path&) { return start(room); };
  return effect;
}

}  // namespace

const Effect response_effect = {.name = "response",
                                .description = "measured response of a room",
                                .key = "room",
                                .stage = "audio",
                                .read = read};

}  // namespace carillon::scene
