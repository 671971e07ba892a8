// Rooms that act on the dry sound, simulated and measured.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "scene/room_scene.hpp"
#include "tests/scene/heard_scene.hpp"

namespace carillon::scene {
namespace {

const std::string clip = "audio: {seconds: 0.2, sample_rate: 16000}\n";

RoomScene room_with(const std::string& keys) {
  core::ConfigNode root = core::ConfigNode::parse(
      "audio: {seconds: 0.5}\nroom: {input: dry, " + keys + "}\n", "room.yaml");
  const Scene scene = read_scene(root, "room.yaml", {});
  RoomScene room = read_room(root, scene);
  root.finish();
  return room;
}

Room draw(const RoomScene& room, std::uint64_t id, std::size_t part = 0) {
  Sound sound;
  sound.seed = 7;
  sound.id = id;
  sound.part = part;
  sound.parts = 9;
  return room_of(room, sound, {});
}

std::string refusal(const std::string& text) {
  try {
    core::ConfigNode root = core::ConfigNode::parse(text, "scene.yaml");
    read_scene(root, "scene.yaml");
    root.finish();
  } catch (const core::ConfigError& error) {
    return error.what();
  }
  return "";
}

void expect_words(const std::string& text, const std::vector<std::string>& words) {
  const std::string found = refusal(text);
  for (const std::string& word : words) {
    EXPECT_NE(found.find(word), std::string::npos) << text << "\n" << found;
  }
}

TEST(DryRoom, PlacesAreWithinTheRoomAndApart) {
  const RoomScene scene = room_with("dimensions: [[2, 6], [3, 5], 2.5], rt60: [0.2 s, 0.4 s]");
  std::set<double> distances;
  for (std::uint64_t id = 0; id < 300; ++id) {
    const Room room = draw(scene, id);
    ASSERT_EQ(room.listeners.size(), 1u);
    const Vec3 listener = room.source + room.listeners[0];
    for (const Vec3& place : {room.source, listener}) {
      EXPECT_TRUE((place.array() >= 0.0999 * room.size.array()).all());
      EXPECT_TRUE((place.array() <= 0.9001 * room.size.array()).all());
    }
    EXPECT_GE(room.listeners[0].norm(), 0.5);
    distances.insert(room.listeners[0].norm());
  }
  EXPECT_EQ(distances.size(), 20u) << "as many as there are rooms";
}

TEST(DryRoom, InASmallBoxPlacesAreAsFarApartAsTheyCanBe) {
  const RoomScene scene = room_with("dimensions: [30 cm, 20 cm, 10 cm], absorption: 0.5");
  for (std::uint64_t id = 0; id < 50; ++id) {
    EXPECT_GE(draw(scene, id).listeners[0].norm(), 0.25 * 0.8 * std::sqrt(0.14));
  }
}

TEST(DryRoom, ReverberationTimesAreDrawnBetweenTwo) {
  const RoomScene scene = room_with("dimensions: [5, 4, 3], rt60: [0.2 s, 0.8 s], count: 200");
  double low = 1, high = 0;
  for (std::uint64_t id = 0; id < 300; ++id) {
    const Room room = draw(scene, id);
    const double rt60 = synth::room::eyring(
        room.size, synth::room::mean_absorption(room.size, room.walls), scene.air)[3];
    EXPECT_GE(rt60, 0.2 - 1e-9);
    EXPECT_LT(rt60, 0.8 + 1e-9);
    low = std::min(low, rt60);
    high = std::max(high, rt60);
  }
  EXPECT_LT(low, 0.23);
  EXPECT_GT(high, 0.77);
}

TEST(DryRoom, WhereNothingIsDrawnThereIsOneRoom) {
  const RoomScene scene =
      room_with("dimensions: [5, 4, 3], source: [1, 1, 1], listener: [3, 2, 1.5], rt60: 0.4");
  EXPECT_FALSE(scene.drawn);
  for (std::size_t part = 0; part < 9; ++part) {
    const Room room = draw(scene, part, part);
    EXPECT_EQ(room.number, static_cast<std::int64_t>(part));
    EXPECT_EQ(room.listeners[0], Vec3(2, 1, 0.5));
  }
}

TEST(DryRoom, RoomsOfPartsDiffer) {
  const RoomScene scene = room_with("dimensions: [5, 4, 3], rt60: 0.4, count: 3");
  std::set<double> of_part[9];
  std::set<double> all;
  for (std::size_t part = 0; part < 9; ++part) {
    for (std::uint64_t id = 0; id < 60; ++id) {
      of_part[part].insert(draw(scene, id, part).listeners[0].x());
    }
    EXPECT_EQ(of_part[part].size(), 3u);
    all.insert(of_part[part].begin(), of_part[part].end());
  }
  EXPECT_EQ(all.size(), 27u);
}

// The sound that is heard without a room, convolved with the room's response.
TEST(DryRoom, IsTheDrySoundConvolvedWithTheRoomsResponse) {
  const std::string room =
      "room: {input: dry, dimensions: [5, 4, 3], source: [1, 1, 1], listener: [3, 2, 1.5], "
      "absorption: 0.3}\n";
  const Heard dry = hear(clip, effects(), 1);
  const Heard wet = hear(clip + room, effects(), 1);
  EXPECT_TRUE(wet.trace.effects.contains("room"));
  EXPECT_TRUE(wet.trace.effects.contains("tail"));
  EXPECT_FALSE(wet.trace.effects.contains("radiation"));
  synth::room::RoomOptions options;
  options.source = Vec3(1, 1, 1);
  options.listener = Vec3(3, 2, 1.5);
  options.sample_rate = 16000;
  options.count = dry.audio.size();
  options.seed = 3;
  options.walls = synth::room::same_on_all_walls({0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3});
  // The seed of the scene is that of hear(); the tail's noise is keyed by it.
  const synth::room::RoomResponse response = synth::room::room_response(options);
  std::vector<double> whole(dry.audio.size(), 0.0);
  whole[0] = 1;
  for (std::size_t i = 0; i < response.images.size(); ++i) whole[i] += response.images[i];
  for (std::size_t i = 0; i < response.tail.size(); ++i) whole[i] += response.tail[i];
  std::vector<double> through_air(dry.audio.size(), 0.0);
  for (std::size_t n = 0; n < through_air.size(); ++n) {
    if (response.air.empty()) through_air[n] = dry.audio[n];
    for (std::size_t k = 0; k < response.air.size() && k <= n; ++k) {
      through_air[n] += response.air[k] * dry.audio[n - k];
    }
  }
  double peak = 0;
  for (const float value : dry.audio) peak = std::max(peak, std::abs(static_cast<double>(value)));
  for (std::size_t n = 0; n < whole.size(); ++n) {
    double heard = 0;
    for (std::size_t k = 0; k <= n; ++k) heard += whole[k] * through_air[n - k];
    ASSERT_NEAR(wet.audio[n], heard, 1e-6 * peak) << n;
  }
  EXPECT_EQ(wet.record.at("room_listener"), nlohmann::json({3.0, 2.0, 1.5}));
  EXPECT_EQ(wet.record.at("tail_level").size(), 1u);
}

TEST(DryRoom, SaysWhatAsksForIt) {
  core::ConfigNode root = core::ConfigNode::parse(
      clip + "room: {input: dry, dimensions: [5, 4, 3], rt60: 0.4}\n", "scene.yaml");
  const Scene scene = read_scene(root, "scene.yaml");
  root.finish();
  for (const PlannedEffect& effect : plan_effects(scene)) {
    if (effect.name == "room" || effect.name == "tail") {
      EXPECT_TRUE(effect.enabled);
      EXPECT_EQ(effect.reason, "room: (scene.yaml:2), for the dry sound");
    }
    if (effect.name == "response") {
      EXPECT_EQ(effect.reason, "no room.responses:");
    }
  }
}

TEST(DryRoom, RefusesWhatCannotBe) {
  const std::string ear = "listeners: [{position: [0, 0, 1]}]\n";
  const std::string room = "room: {input: dry, dimensions: [5, 4, 3], rt60: 0.4}\n";
  expect_words(clip + ear + room, {"room.input", "`listeners` are placed", "input: radiated"});
  EXPECT_EQ(refusal(clip + ear + room + "effects: {radiation: off}\n"), "");
  expect_words(clip + "room: {input: wet, dimensions: [5, 4, 3], rt60: 0.4}\n",
               {"room.input", "radiated", "dry"});
  expect_words(clip + "room: {dimensions: [5, 4, 3], listener: [1, 1, 1], rt60: 0.4}\n",
               {"room.listener", "input: dry"});
  expect_words(clip + "room: {input: dry, dimensions: [5, 4, 3], listener: [1, 9, 1], rt60: 1}\n",
               {"room.listener", "not inside the room"});
  expect_words(clip +
                   "room: {input: dry, dimensions: [5, 4, 3], listener: [1, 1, 1], "
                   "source: [1, 1, 1], rt60: 0.4}\n",
               {"room.listener"});
  expect_words(clip + "room: {input: dry, dimensions: [5, 4, 3], rt60: [0.4 s, 400 s]}\n",
               {"room.rt60", "air alone"});
  expect_words(clip + "room: {input: dry, dimensions: [5, 4, 3], rt60: [0.4 s, 0.2 s]}\n",
               {"room.rt60", "ends below it"});
  expect_words(clip + "room: {input: dry, dimensions: [5, 4, 3], margin: 2 m, rt60: 0.4}\n",
               {"room.dimensions", "no place"});
}

TEST(DryRoom, IsOffWhereNothingIsReflected) {
  core::ConfigNode root = core::ConfigNode::parse(
      clip + "room: {input: dry, dimensions: [5, 4, 3], absorption: 1}\n", "scene.yaml");
  const Scene scene = read_scene(root, "scene.yaml");
  EXPECT_FALSE(scene.runs("room"));
  EXPECT_FALSE(scene.runs("tail"));
}

/// A folder with a response in each file.
std::string folder_with(const core::TemporaryFolder& folder,
                        const std::vector<std::vector<float>>& responses, int rate = 16000) {
  for (std::size_t k = 0; k < responses.size(); ++k) {
    core::AudioClip file;
    file.sample_rate = rate;
    file.samples = responses[k];
    core::write_wav(folder / (std::to_string(k) + ".wav"), file, core::SampleFormat::float32);
  }
  return folder.path().string();
}

std::string measured(const std::string& path, const std::string& more = "") {
  return "room: {input: dry, responses: " + path + more + "}\n";
}

double largest(std::span<const float> samples) {
  double peak = 0;
  for (const float value : samples) peak = std::max(peak, std::abs(static_cast<double>(value)));
  return peak;
}

TEST(MeasuredRoom, APulseLeavesTheDrySoundAsItIs) {
  const core::TemporaryFolder folder;
  std::vector<float> pulse(300, 0.0F);
  pulse[120] = 0.3F;
  const Heard dry = hear(clip);
  const Heard wet = hear(clip + measured(folder_with(folder, {pulse})));
  ASSERT_EQ(wet.audio.size(), dry.audio.size());
  for (std::size_t n = 0; n < dry.audio.size(); ++n) {
    ASSERT_NEAR(wet.audio[n], dry.audio[n], 1e-7 * largest(dry.audio)) << n;
  }
  EXPECT_EQ(wet.trace.effects.at("response").calls, 2);
  EXPECT_FALSE(wet.trace.effects.contains("room"));
  EXPECT_EQ(wet.record.at("room_response"), "0.wav");
  EXPECT_EQ(wet.record.at("room_response_channel"), 1);
}

TEST(MeasuredRoom, EchoesComeLaterAndWeaker) {
  const core::TemporaryFolder folder;
  std::vector<float> echo(2000, 0.0F);
  echo[10] = 0.5F;
  echo[10 + 800] = -0.2F;
  const Heard dry = hear(clip, effects(), 1);
  const Heard wet = hear(clip + measured(folder_with(folder, {echo})), effects(), 1);
  for (std::size_t n = 0; n < dry.audio.size(); ++n) {
    const double echoed = n < 800 ? 0 : -0.4 * dry.audio[n - 800];
    ASSERT_NEAR(wet.audio[n], dry.audio[n] + echoed, 1e-6 * largest(dry.audio)) << n;
  }
}

// Responses beyond the clip, of one sample, and all between.
TEST(MeasuredRoom, AnyLengthIsTheSumOfItsEchoes) {
  const Heard dry = hear(clip, effects(), 1);
  rc::check([&] {
    const core::TemporaryFolder folder;
    const auto length = *rc::gen::inRange<std::size_t>(1, 8000);
    std::vector<float> response(length, 0.0F);
    response[0] = 1;
    const auto at = *rc::gen::inRange<std::size_t>(0, length);
    if (at > 100) response[at] = 0.25F;
    const Heard wet = hear(clip + measured(folder_with(folder, {response})), effects(), 1);
    for (std::size_t n = 0; n < dry.audio.size(); ++n) {
      const double echoed = at > 100 && n >= at ? 0.25 * dry.audio[n - at] : 0;
      RC_ASSERT(std::abs(wet.audio[n] - dry.audio[n] - echoed) < 1e-6 * largest(dry.audio));
    }
  });
}

TEST(MeasuredRoom, IsLinear) {
  const core::TemporaryFolder folder;
  const auto noise = [](std::size_t count, std::uint64_t item, double decay) {
    core::RandomStream random(1, item, "test.response");
    std::vector<float> samples(count);
    for (std::size_t i = 0; i < count; ++i) {
      samples[i] = static_cast<float>(random.normal() * std::exp(-static_cast<double>(i) / decay));
    }
    return samples;
  };
  core::ConfigNode root = core::ConfigNode::parse(
      clip + measured(folder_with(folder, {noise(3000, 1, 500)})), "scene.yaml");
  const Scene scene = read_scene(root, "scene.yaml");
  const auto found = std::find_if(
      scene.effects.begin(), scene.effects.end(),
      [](const EffectDecision& effect) { return effect.effect->name == std::string("response"); });
  const EffectParts parts = found->in_scene.start("");
  const auto heard = [&](std::vector<float> dry) {
    Sound sound;
    sound.audio = std::move(dry);
    parts.audio(sound);
    return sound.audio;
  };
  const std::vector<float> one = noise(3200, 2, 1000), other = noise(3200, 3, 300);
  std::vector<float> sum(one.size());
  for (std::size_t n = 0; n < sum.size(); ++n) sum[n] = one[n] - 2 * other[n];
  const std::vector<float> wet = heard(sum), wet_one = heard(one), wet_other = heard(other);
  for (std::size_t n = 0; n < sum.size(); ++n) {
    ASSERT_NEAR(wet[n], wet_one[n] - 2 * wet_other[n], 1e-6 * largest(wet)) << n;
  }
}

// All listeners hear through one response, which follows the pressure at each of them.
TEST(MeasuredRoom, ListenersHearThroughOneResponse) {
  const core::TemporaryFolder folder;
  const std::string path = folder_with(folder, {{1, 0, 0, 0.5F, 0}});
  const std::string ears =
      "listeners: [{position: [0.5, 0.3, 0.4]}, {position: [1, 0, 0]}]\n"
      "radiation: {min_sources: 40, max_sources: 40}\nclick: {held: true}\n";
  const Heard open = hear(clip + ears, effects(), 1);
  const Heard wet = hear(clip + ears + "room: {responses: " + path + "}\n", effects(), 1);
  const double scale = 1 / std::sqrt(1.25);  // the energy of the first 2.5 ms is 1
  ASSERT_EQ(open.audio.size(), 6400u);
  for (std::size_t n = 0; n < open.audio.size(); ++n) {
    const double echo = n % 3200 < 3 ? 0 : 0.5 * open.audio[n - 3];
    ASSERT_NEAR(wet.audio[n], scale * (open.audio[n] + echo), 1e-6 * largest(open.audio)) << n;
  }
  core::ConfigNode root =
      core::ConfigNode::parse(clip + "room: {responses: " + path + "}\n", "scene.yaml");
  const Scene scene = read_scene(root, "scene.yaml");
  for (const PlannedEffect& effect : plan_effects(scene)) {
    if (effect.name == "response") {
      EXPECT_EQ(effect.reason, "no listener is placed; `room.input: dry` takes the dry sound");
    }
  }
}

TEST(MeasuredRoom, RefusesKeysOfSimulatedRooms) {
  const core::TemporaryFolder folder;
  const std::string path = folder_with(folder, {{1, 0, 0, 0.5F, 0}});
  expect_words(clip + measured(path, ", rt60: 0.4"), {"room.rt60", "simulated", "responses"});
  expect_words(clip + measured(path, ", dimensions: [5, 4, 3]"), {"room.dimensions"});
  expect_words(clip + measured(path, ", channel: 2"), {"room.responses", "no channel 2: it has 1"});
  expect_words(clip + measured(path + "/absent"), {"room.responses", "no such folder"});
  expect_words(clip + measured(path) + "effects: {room: on}\n", {"cannot be on", "measured"});
}

TEST(MeasuredRoom, ContentIsThatOfTheFiles) {
  const core::TemporaryFolder folder;
  const std::string path = folder_with(folder, {{1, 0, 0, 0.5F, 0}, {1, 0, 0.25F}});
  const auto content = [&] {
    core::ConfigNode root = core::ConfigNode::parse(clip + measured(path), "scene.yaml");
    for (const EffectDecision& effect : read_scene(root, "scene.yaml").effects) {
      if (std::string(effect.effect->name) == "response") return effect.in_scene.content();
    }
    return std::string();
  };
  const std::string before = content();
  EXPECT_EQ(before.size(), 64u);
  EXPECT_EQ(content(), before);
  folder_with(folder, {{1, 0, 0, 0.51F, 0}});
  EXPECT_NE(content(), before);
}

}  // namespace
}  // namespace carillon::scene
