// Rooms as scenes have them: pools, what is drawn, and why they are off.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/error.hpp"
#include "scene/columns.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/room_scene.hpp"
#include "synth/room/wall_materials.hpp"

namespace carillon::scene {
namespace {

using core::ConfigNode;

Scene scene_with(std::vector<Eigen::Vector3d> listeners = {{0.5, 0.3, 0.4}}) {
  Scene scene;
  scene.audio.seconds = 0.5;
  for (const auto& place : listeners) scene.listeners.push_back({place});
  scene.effects.push_back({&radiation_effect, true, "", {}});
  return scene;
}

SceneEffect read(const Effect& effect, const std::string& text, const Scene& scene = scene_with()) {
  ConfigNode root = ConfigNode::parse(text, "room.yaml");
  SceneEffect found = effect.read(root, scene);
  root.finish();
  return found;
}

std::string refusal(const std::string& text, const Scene& scene = scene_with()) {
  try {
    read(room_effect, text, scene);
  } catch (const core::ConfigError& error) {
    return error.what();
  }
  return "";
}

void expect_refused(const std::string& text, std::vector<std::string> words,
                    const Scene& scene = scene_with()) {
  const std::string found = refusal(text, scene);
  for (const std::string& word : words) {
    EXPECT_NE(found.find(word), std::string::npos) << text << "\n" << found;
  }
}

TEST(RoomEffect, SaysWhyItIsOff) {
  const std::string room = "room: {dimensions: [5, 4, 3], source: [1, 1, 1], absorption: 0.3}\n";
  EXPECT_EQ(read(room_effect, "{}").reason_off, "no room:");
  EXPECT_EQ(read(tail_effect, "{}").reason_off, "no room:");
  for (const Effect* effect : {&room_effect, &tail_effect}) {
    EXPECT_EQ(read(*effect, room, scene_with({})).reason_off,
              "no listener is placed; `room.input: dry` takes the dry sound");
  }
  EXPECT_EQ(read(room_effect, room).reason_off, "");
  EXPECT_EQ(read(tail_effect, room).reason_off, "");
  EXPECT_EQ(read(room_effect, "\n" + room).asked_by, "room: (room.yaml:2)");
  const std::string absorbent = "room: {dimensions: [5, 4, 3], absorption: 0.999}\n";
  EXPECT_TRUE(
      read(tail_effect, absorbent)
          .reason_off.starts_with("absorption so high that the tail is inaudible (energy -"))
      << read(tail_effect, absorbent).reason_off;
  EXPECT_NE(read(tail_effect, "room: {dimensions: [800, 700, 600], absorption: 0.1}\n")
                .reason_off.find("beyond the clip"),
            std::string::npos);
}

TEST(RoomEffect, RefusesWhatCannotBe) {
  expect_refused("room: {dimensions: [5, 4, 3], absorption: 0.3, rt60: 0.5 s}\n",
                 {"room.rt60", "absorption and rt60", "room.yaml:1"});
  expect_refused("room: {dimensions: [5, 4, 3]}\n", {"neither absorption nor walls nor rt60"});
  expect_refused("room: {dimensions: [5, 4, 3], walls: brick, rt60: 0.5 s}\n",
                 {"room.rt60", "walls and rt60", "room.yaml:1"});
  expect_refused("room: {dimensions: [5, 4, 3], walls: brik}\n",
                 {"room.walls", "did you mean \"brick\"?", "room.yaml:1"});
  expect_refused("room: {dimensions: [5, 4, 3], walls: {others: brick, z0: carpet}}\n",
                 {"room.walls.z0", "this wall is called floor"});
  expect_refused("room: {dimensions: [5, 4, 3], walls: {x0: brick, floor: carpet}}\n",
                 {"no absorption of the wall x1", "others"});
  expect_refused("room: {dimensions: [5, 4, 3], rt60: 400 s}\n",
                 {"1000 Hz", "air alone", "5 x 4 x 3 m"});
  expect_refused("room: {dimensions: [[5, 9], 4, 3], rt60: 24 ms}\n",
                 {"1000 Hz", "9 x 4 x 3 m", "0.99"});
  expect_refused("room: {dimensions: [5, 4, 3], rt60: [1, 1, 1, 1, 1, 1, 1, 1]}\n",
                 {"16000 Hz", "longer than the 0.47"});
  expect_refused("room: {dimensions: [5, 4, 3], absorption: 1.2}\n", {"0 to 1"});
  expect_refused("room: {dimensions: [5, 4, 3], absorption: [0.1, 0.2]}\n", {"6 to 8"});
  expect_refused("room: {dimensions: [5, 4, 3], absorption: {floor: 0.2}}\n", {"x0"});
  expect_refused("room: {dimensions: [5, 4], absorption: 0.2}\n", {"list of 3"});
  expect_refused("room: {dimensions: [5, 4, 3], source: [6, 1, 1], absorption: 0.2}\n",
                 {"room.source", "not inside the room of 5 x 4 x 3 m"});
  expect_refused("room: {dimensions: [0.4, 4, 3], absorption: 0.2}\n",
                 {"0.4 x 4 x 3 m", "no place"});
  expect_refused("room: {dimensions: [5, 4, 3], absorption: 0.2, humidity: 2}\n", {"humidity"});
  expect_refused("room: {dimensions: [5, 4, 3], absorption: 0.2, image_order: 21}\n", {"0 to 20"});
}

// Named walls are the table's numbers, alone or beside numbers.
TEST(RoomEffect, TakesWallsByName) {
  const auto walls = [](const std::string& text) {
    ConfigNode root =
        ConfigNode::parse("room: {dimensions: [5, 4, 3], " + text + "}\n", "room.yaml");
    const RoomScene room = read_room(root, scene_with());
    root.finish();
    return *room.walls;
  };
  const auto of = [](const char* name) { return synth::room::find_wall_material(name).absorption; };
  EXPECT_EQ(walls("walls: brick"), synth::room::same_on_all_walls(of("brick")));
  EXPECT_EQ(walls("absorption: brick"), walls("walls: brick"));
  auto mixed = synth::room::same_on_all_walls(of("plaster"));
  mixed[0] = of("window");
  mixed[4] = of("carpet_heavy");
  mixed[5] = synth::room::octaves_of(std::array{0.1, 0.2, 0.3, 0.4, 0.5, 0.6});
  EXPECT_EQ(walls("walls: {others: plaster, x0: window, floor: carpet_heavy, "
                  "ceiling: [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]}"),
            mixed);
  EXPECT_EQ(walls("absorption: {walls: plaster, x0: window, floor: carpet_heavy, "
                  "ceiling: [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]}"),
            mixed);
  EXPECT_EQ(walls("walls: 0.3"), walls("absorption: 0.3"));
}

RoomScene pool() {
  ConfigNode root = ConfigNode::parse(
      "room: {dimensions: [[3, 6], [3, 5], 2.5], rt60: 0.4 s, count: 5}\n", "room.yaml");
  return read_room(root, scene_with());
}

TEST(Rooms, OfPartsAreDisjointAndOfOnePartComeAgain) {
  const RoomScene scene = pool();
  std::set<std::int64_t> numbers[3];
  std::set<double> sides[3];
  for (std::size_t part = 0; part < 3; ++part) {
    for (std::uint64_t id = 0; id < 60; ++id) {
      Sound sound;
      sound.seed = 7;
      sound.id = id;
      sound.part = part;
      sound.parts = 3;
      const std::vector<Eigen::Vector3d> listeners = {{0.5, 0.3, 0.4}, {-1, 0, 0}};
      const Room room = room_of(scene, sound, listeners);
      numbers[part].insert(room.number);
      sides[part].insert(room.size.x());
      EXPECT_GE(room.size.x(), 3);
      EXPECT_LT(room.size.x(), 6);
      EXPECT_EQ(room.size.z(), 2.5);
      for (const Eigen::Vector3d& listener : listeners) {
        EXPECT_NO_THROW(synth::room::check_room(room.size, room.source, room.source + listener, 3));
      }
      const auto rt60 = synth::room::eyring(
          room.size, synth::room::mean_absorption(room.size, room.walls), scene.air);
      EXPECT_NEAR(rt60[3], 0.4, 1e-9);
    }
    EXPECT_EQ(numbers[part].size(), 5U);
    EXPECT_EQ(sides[part].size(), 5U);
  }
  for (const double side : sides[0])
    EXPECT_FALSE(sides[1].contains(side) || sides[2].contains(side));
  for (const auto n : numbers[1]) EXPECT_FALSE(numbers[0].contains(n) || numbers[2].contains(n));
}

struct Wet {
  std::vector<float> audio;
  nlohmann::json record;
};

/// A click through the effects in their order.
Wet click(const std::string& text, bool room, bool tail) {
  const Scene scene = scene_with();
  RingingObject object;
  object.centre = {0.1, 0.2, 0.3};
  object.listeners = {{object.centre + scene.listeners[0].position}};
  core::Columns record(columns());
  Sound sound;
  sound.object = &object;
  sound.record = &record;
  sound.audio.assign(scene.audio.samples(), 0.0F);
  sound.audio[0] = 1;
  if (room) read(room_effect, text).start("").audio(sound);
  if (tail) read(tail_effect, text).start("").audio(sound);
  return {sound.audio, record.last_row()};
}

// Reverberation is made of the direct sound: early reflections are not reverberated again.
TEST(RoomEffect, AClickIsTheResponse) {
  const std::string text = "room: {dimensions: [5, 4, 3], source: [1, 1, 1], absorption: 0.3}\n";
  const Wet both = click(text, true, true);
  const Wet early = click(text, true, false);
  const Wet late = click(text, false, true);
  synth::room::RoomOptions options;
  options.listener = Eigen::Vector3d(1.5, 1.3, 1.4);
  options.count = both.audio.size();
  synth::room::OctaveValues absorption;
  absorption.fill(0.3);
  options.walls = synth::room::same_on_all_walls(absorption);
  const synth::room::RoomResponse response = synth::room::room_response(options);
  ASSERT_FALSE(response.tail.empty());
  ASSERT_FALSE(response.air.empty());
  const auto through_air = [&](const std::vector<double>& part) {
    std::vector<double> heard(both.audio.size(), 0.0);
    for (std::size_t k = 0; k < response.air.size(); ++k) {
      for (std::size_t n = 0; n < part.size() && n + k < heard.size(); ++n) {
        heard[n + k] += response.air[k] * part[n];
      }
    }
    return heard;
  };
  const auto directs = through_air({1.0});
  const auto images = through_air(response.images);
  const auto tails = through_air(response.tail);
  for (std::size_t n = 0; n < both.audio.size(); ++n) {
    const double direct = directs[n];
    const double image = images[n];
    const double tail = tails[n];
    ASSERT_NEAR(both.audio[n], direct + image + tail, 1e-6) << n;
    ASSERT_NEAR(early.audio[n], direct + image, 1e-6) << n;
    ASSERT_NEAR(late.audio[n], direct + tail, 1e-6) << n;
  }
  EXPECT_EQ(both.record.at("room"), 0);
  EXPECT_EQ(late.record.at("room"), 0);
  EXPECT_TRUE(both.record.contains("room_rt60"));
  EXPECT_TRUE(both.record.contains("tail_level"));
}

TEST(RoomEffect, IsOffWhereNothingIsReflected) {
  const std::string walls = "room: {dimensions: [5, 4, 3], source: [1, 1, 1], absorption: 1}\n";
  const Scene near = scene_with({{0.1, 0, 0}});
  EXPECT_EQ(read(room_effect, walls, near).reason_off, "walls that reflect nothing");
  const std::string far = "room: {dimensions: [1 km, 1 km, 1 km], absorption: 0.3}\n";
  EXPECT_NE(read(room_effect, far, near).reason_off.find("first reflection"), std::string::npos);
  // Air is heard from afar, reflections or none.
  EXPECT_EQ(read(room_effect, far, scene_with({{100, 0, 0}})).reason_off, "");
}

TEST(RoomEffect, ResponsesCountInThePlan) {
  const auto cost = [](const std::string& order) {
    return read(room_effect,
                "room: {dimensions: [5, 4, 3], absorption: 0.3, image_order: " + order + "}\n")
        .seconds_per_sound;
  };
  EXPECT_GT(cost("20"), 10 * cost("3"));
  const std::string shared =
      "room: {dimensions: [5, 4, 3], source: [1, 1, 1], absorption: 0.3, image_order: 20}\n";
  EXPECT_LT(read(room_effect, shared).seconds_per_sound, cost("20") / 4);
  // Of a shape in ten materials ten times as many sounds share a response.
  Scene materials = scene_with();
  materials.strikes.per_object = 100;
  const std::string pool = "room: {dimensions: [5, 4, 3], absorption: 0.3, image_order: 20}\n";
  const double alone = read(room_effect, pool, materials).seconds_per_sound;
  materials.variants = 10;
  const double together = read(room_effect, pool, materials).seconds_per_sound;
  materials.strikes.per_object = 1000000;
  const double convolution = read(room_effect, pool, materials).seconds_per_sound;
  EXPECT_NEAR((alone - convolution) / (together - convolution), 10, 0.1);
}

// A shape's strikes draw from one pool for each part that strikes are split into.
TEST(RoomEffect, PoolsOfPartsTakeMemory) {
  const Scene whole = scene_with();
  Scene split = whole;
  split.parts = 9;
  const std::string pool = "room: {dimensions: [[4, 5], 4, 3], absorption: 0.3, count: 2}\n";
  EXPECT_DOUBLE_EQ(read(room_effect, pool, split).memory,
                   3 * read(room_effect, pool, whole).memory);
  const std::string one = "room: {dimensions: [5, 4, 3], source: [1, 1, 1], absorption: 0.3}\n";
  EXPECT_EQ(read(room_effect, one, split).memory, read(room_effect, one, whole).memory);
}

TEST(RoomEffect, TailIsJudgedWhereItBeginsEarliest) {
  Scene scene = scene_with();
  scene.audio.seconds = 0.13;
  const auto reason = [&](const std::string& source) {
    return read(tail_effect,
                "room: {dimensions: [20, 20, 20], absorption: 0.3, source: " + source + "}\n",
                scene)
        .reason_off;
  };
  EXPECT_NE(reason("[10, 10, 10]"), "");
  EXPECT_EQ(reason("[2.5, 2.5, 2.5]"), "");
  EXPECT_EQ(reason("random"), "");
  // Nowhere in the room does it begin earlier than at its edges.
  scene.audio.seconds = 0.05;
  const std::string all = reason("random");
  ASSERT_TRUE(all.starts_with("the tail begins ")) << all;
  const double earliest = std::stod(all.substr(16));
  ConfigNode root =
      ConfigNode::parse("room: {dimensions: [20, 20, 20], absorption: 0.3}\n", "r.yaml");
  const RoomScene room = read_room(root, scene);
  for (std::uint64_t id = 0; id < 200; ++id) {
    Sound sound;
    sound.seed = 3;
    sound.id = id;
    const Eigen::Vector3d ear = scene.listeners[0].position;
    const synth::room::TailPlan plan = synth::room::room_tail_plan(
        room_options(room, room_of(room, sound, {ear}), ear, 44100, 22050, 0));
    EXPECT_GT(plan.start, 0.95 * earliest);  // which is told with two digits
  }
}

}  // namespace
}  // namespace carillon::scene
