// What a scene does not call for is not called, takes no memory and changes no bit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>

#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "scene/chain.hpp"
#include "tests/scene/heard_scene.hpp"

namespace carillon::scene {
namespace {

/// What calls for each effect that is not in every scene. All of it together is a scene in which
/// everything runs.
const std::map<std::string, std::string>& calls() {
  static const std::map<std::string, std::string> text = {
      {"radiation",
       "listeners:\n  - position: [0.5, 0.3, 0.4]\n"
       "radiation: {min_sources: 40, max_sources: 40}\n"},
      {"supports", "supports: {contacts: [{kind: finger, count: 2}]}\n"},
      {"noise", "noise: {kind: [white, pink], snr: [10 dB, 20 dB]}\n"},
      {"recording",
       "recording: {low_cut: 40 Hz, high_cut: 7 kHz, codec: vorbis, length: 0.1 s, shift: [0 s, "
       "0.02 s], gain: [-6 dB, 6 dB], clip: 1, bits: 16}\n"},
      {"striker", "striker: {kind: [metal, wood], speed: [0.5 m/s, 2 m/s]}\n"},
      {"click", "click: {held: false}\n"},
      // Of its reflections and of its tail.
      {"room", "room: {dimensions: [5, 4, 3], source: [1, 1, 1], absorption: 0.2}\n"},
  };
  return text;
}

/// A room that was measured, in the place of the simulated one.
std::string measured_room() {
  static const core::TemporaryFolder folder;
  static const std::string file = (folder / "hall.wav").string();
  if (!std::filesystem::exists(file)) {
    core::AudioClip clip;
    clip.sample_rate = 16000;
    clip.samples = {1, 0, 0, 0.5, 0, -0.25, 0};
    core::write_wav(file, clip, core::SampleFormat::float32);
  }
  return "room: {responses: " + file + "}\n";
}

/// A scene with everything but one effect.
/// @param about  the effect that the scene is for: what would stand in its place is left out
std::string scene_without(const std::string& name, const std::string& about) {
  std::string text = "audio: {seconds: 0.2, sample_rate: 16000}\n";
  for (const auto& [effect, keys] : calls()) {
    // A striker gives the force that the contact pulse would.
    if (effect == (name == "response" ? "room" : name)) continue;
    if (about == "contact" && effect == "striker") continue;
    text += about == "response" && effect == "room" ? measured_room() : keys;
  }
  std::string switches;
  for (const Effect& effect : effects()) {
    if (effect.name == name) switches += "  " + name + ": off\n";
  }
  return text + (switches.empty() ? "" : "effects:\n" + switches);
}

class EveryEffect : public testing::TestWithParam<const char*> {};

TEST_P(EveryEffect, IsNeitherCalledNorKeptNorHeardWhereItIsOff) {
  const std::string name = GetParam();
  const std::string text = scene_without(name, name);
  std::vector<Effect> others;
  for (const Effect& effect : effects()) {
    if (effect.name != name) others.push_back(effect);
  }
  // A program that never heard of the effect cannot read a switch for it.
  std::string unswitched = text;
  const std::string off = "  " + name + ": off\n";
  if (const auto at = unswitched.find(off); at != std::string::npos)
    unswitched.erase(at, off.size());
  if (unswitched.ends_with("effects:\n")) unswitched.resize(unswitched.size() - 9);

  hear(text);  // what libraries allocate once
  const Heard with = hear(text);
  const Heard without = hear(unswitched, others);
  EXPECT_FALSE(with.trace.effects.contains(name));
  EXPECT_EQ(with.audio, without.audio);
  EXPECT_EQ(with.record, without.record);
  EXPECT_EQ(with.allocated, without.allocated);
  for (const auto& [other, entry] : without.trace.effects) {
    EXPECT_EQ(with.trace.effects.at(other).calls, entry.calls) << other;
  }
}

TEST_P(EveryEffect, RunsAndIsRecordedInTheTraceWhereItIsOn) {
  const std::string name = GetParam();
  const Heard all = hear(scene_without("", name));
  ASSERT_TRUE(all.trace.effects.contains(name));
  EXPECT_GT(all.trace.effects.at(name).calls, 0);
  const Heard without = hear(scene_without(name, name));
  EXPECT_TRUE(all.audio != without.audio || all.record != without.record);
  for (const float value : all.audio) ASSERT_TRUE(std::isfinite(value));
}

// A key that stands there, switched off, is as good as none.
TEST(Effects, SwitchedOffAreAsIfTheirKeyWereNotThere) {
  const std::string ear = "listeners:\n  - position: [0.5, 0.3, 0.4]\n";
  const std::string base = "audio: {seconds: 0.2, sample_rate: 16000}\n" + ear +
                           "radiation: {min_sources: 40, max_sources: 40}\n";
  hear(base);  // what libraries allocate once
  const Heard without = hear(base);
  for (const auto& [name, key] : calls()) {
    if (name == "radiation" || name == "click") continue;  // these run with a listener alone
    const std::string off =
        fmt::format("effects: {{{}: off{}}}\n", name, name == "room" ? ", tail: off" : "");
    const Heard with = hear(fmt::format("{}{}{}", base, key, off));
    EXPECT_EQ(with.audio, without.audio) << name;
    EXPECT_EQ(with.record, without.record) << name;
    EXPECT_EQ(with.allocated, without.allocated) << name;
    EXPECT_EQ(with.trace.effects.size(), without.trace.effects.size()) << name;
    EXPECT_NE(hear(base + key).audio, without.audio) << name;
  }
  const std::string dry = "audio: {seconds: 0.2, sample_rate: 16000}\n";
  EXPECT_EQ(hear(base + "effects: {radiation: off}\n").audio, hear(dry).audio);
}

/// Effects with working parts; views, and what scenes that move are made of
/// (tests/end_to_end/scenes.py), are made elsewhere.
std::vector<const char*> working_effects() {
  std::vector<const char*> names;
  for (const Effect& effect : effects()) {
    const std::string stage = effect.stage;
    if (stage != "view" && stage != "motion") names.push_back(effect.name);
  }
  return names;
}

INSTANTIATE_TEST_SUITE_P(Effects, EveryEffect, testing::ValuesIn(working_effects()),
                         [](const auto& name) { return std::string(name.param); });

TEST(Effects, SayWhyTheyAreOnOrOff) {
  core::ConfigNode root = core::ConfigNode::parse(
      "\nlisteners:\n  - position: [0, 0, 1]\neffects: {contact: off, radiation: on}\n", "s.yaml");
  const Scene scene = read_scene(root, "s.yaml");
  std::map<std::string, PlannedEffect> found;
  for (const PlannedEffect& effect : plan_effects(scene)) {
    found[effect.name] = effect;
    EXPECT_FALSE(effect.reason.empty()) << effect.name;
  }
  EXPECT_EQ(found["contact"].reason, "effects.contact: off (s.yaml:4)");
  EXPECT_EQ(found["radiation"].reason, "effects.radiation: on (s.yaml:4)");
  EXPECT_FALSE(found["contact"].enabled);
  EXPECT_TRUE(found["radiation"].enabled);
}

TEST(Effects, CannotBeForcedWithoutWhatTheyNeed) {
  core::ConfigNode root = core::ConfigNode::parse("effects: {radiation: on}\n", "s.yaml");
  try {
    read_scene(root, "s.yaml");
    FAIL();
  } catch (const core::ConfigError& error) {
    EXPECT_NE(error.message().find("s.yaml:1"), std::string::npos) << error.message();
    EXPECT_NE(error.message().find("no listener"), std::string::npos) << error.message();
  }
}

// A room answers pressure in air, not the velocity of a surface.
TEST(Effects, OfAirAreOffWhereRadiationIs) {
  for (const char* off : {"effects: {radiation: off}\n", "radiation: {model: \"off\"}\n"}) {
    core::ConfigNode root =
        core::ConfigNode::parse(std::string("listeners:\n  - position: [0, 0, 1]\n"
                                            "room: {dimensions: [5, 4, 3], rt60: 0.5}\n") +
                                    off,
                                "s.yaml");
    const Scene scene = read_scene(root, "s.yaml");
    root.finish();
    EXPECT_EQ(scene.rows(), 1u);
    for (const char* name : {"radiation", "click", "room", "tail"}) {
      EXPECT_FALSE(scene.runs(name)) << name;
    }
    for (const PlannedEffect& effect : plan_effects(scene)) {
      if (effect.name == "room") {
        EXPECT_EQ(effect.reason,
                  "radiation is off: the dry signal is no pressure; `room.input: dry` takes "
                  "the dry sound");
      }
    }
  }
}

TEST(Effects, SwitchesMayBeTrueOrFalse) {
  core::ConfigNode root = core::ConfigNode::parse(
      "striker: {kind: metal}\neffects: {striker: false, contact: true}\n", "s.yaml");
  const Scene scene = read_scene(root, "s.yaml");
  EXPECT_FALSE(scene.runs("striker"));
  EXPECT_TRUE(scene.runs("contact"));  // which a striker would do in its place
  core::ConfigNode wrong = core::ConfigNode::parse("effects: {contact: maybe}\n", "s.yaml");
  EXPECT_THROW(read_scene(wrong, "s.yaml"), core::ConfigError);
}

TEST(Effects, ActAtTheStageThatTheyName) {
  for (const char* name : working_effects()) {
    core::ConfigNode root = core::ConfigNode::parse(scene_without("", name), "s.yaml");
    for (const EffectDecision& decision : read_scene(root, "s.yaml").effects) {
      if (decision.effect->name != std::string_view(name)) continue;
      ASSERT_TRUE(decision.enabled) << name;
      const EffectParts parts = decision.in_scene.start("");
      const std::map<std::string, bool> does = {
          {"object", static_cast<bool>(parts.object)},
          {"strike", static_cast<bool>(parts.strike)},
          {"rings", static_cast<bool>(parts.rings)},
          {"audio", static_cast<bool>(parts.audio)},
          {"full scale", static_cast<bool>(parts.full_scale)}};
      EXPECT_TRUE(does.at(decision.effect->stage)) << name << ": " << decision.effect->stage;
    }
  }
}

constexpr core::ColumnRule test_rules[] = {{"pair", "float64", "2", "m", "always", ""},
                                           {"one", "float64", "", "1", "always", ""},
                                           {"level", "float64", "", "m/s|Pa", "always", ""}};

TEST(Columns, RefuseSamplesThatDiffer) {
  core::Columns columns(test_rules);
  const std::vector<double> two = {1, 2};
  columns.add<double>("pair", two, {2});
  columns.add("one", 1.0);
  EXPECT_THROW(columns.add<double>("pair", std::span(two).first(1), {1}), std::logic_error);
  EXPECT_THROW(columns.add<double>("pair", std::span(two).first(1), {2}), std::logic_error);
  columns.add<double>("pair", two, {2});
  const core::TemporaryFolder folder;
  EXPECT_THROW(columns.write(core::Hdf5Group::create_file(folder / "columns.h5")),
               std::logic_error);
}

TEST(Columns, RefuseWhatTheirRulesDoNotHave) {
  core::Columns columns(test_rules);
  EXPECT_THROW(columns.add("other", 1.0), std::logic_error);
  EXPECT_THROW(columns.add("one", std::int64_t{1}), std::logic_error);
  EXPECT_THROW(columns.add("pair", 1.0), std::logic_error);
  EXPECT_THROW(columns.add("level", 1.0), std::logic_error) << "which of its units?";
  EXPECT_THROW(columns.add("level", 1.0, "V"), std::logic_error);
}

TEST(Columns, HaveTheUnitsOfTheirRules) {
  core::Columns columns(test_rules);
  columns.add("one", 1.0);
  columns.add("level", 1.0, "Pa");
  const std::vector<double> two = {1, 2};
  columns.add<double>("pair", two, {2});
  std::map<std::string, std::string> units;
  columns.each([&](const std::string& name, const auto&, const core::Extent&,
                   const std::string& unit) { units[name] = unit; });
  EXPECT_EQ(units,
            (std::map<std::string, std::string>{{"one", "1"}, {"level", "Pa"}, {"pair", "m"}}));
}

/// Effects that objects bring which are struck, and so their columns.
bool is_of_an_effect(const core::ColumnRule& rule) {
  const std::string when = rule.when, name = rule.name;
  for (const char* other : {"always", "struck", "mel", "motion", "touch", "movie"}) {
    if (when == other) return false;
  }
  // Of a movie; of a manifest; of strikes that are repeated.
  return name != "depth" && name != "masks" && name != "label_" && name != "strike_times";
}

TEST(Effects, RecordEveryColumnThatIsTheirs) {
  std::string text =
      "audio: {seconds: 0.2, sample_rate: 16000}\n"
      "negative_damping: clamp\n";
  for (const auto& [effect, keys] : calls()) {
    if (effect != "supports") text += keys;
  }
  std::set<std::string> recorded;
  const std::string dry_room = "room: {input: dry, dimensions: [5, 4, 3], rt60: [0.2, 0.4]}\n";
  for (const std::string& other : {calls().at("radiation") + measured_room(), dry_room}) {
    const Heard heard = hear(other);
    for (const auto& [name, value] : heard.record.items()) recorded.insert(name);
  }
  for (const std::string coupling : {"full", "diagonal"}) {
    const Heard heard = hear(fmt::format(
        "{}supports: {{coupling: {}, contacts: [{{kind: finger, count: 2, pool: 3}}]}}\n", text,
        coupling));
    for (const auto& [name, value] : heard.record.items()) recorded.insert(name);
  }
  for (const core::ColumnRule& rule : columns()) {
    EXPECT_EQ(recorded.contains(rule.name), is_of_an_effect(rule)) << rule.name;
  }
}

TEST(Effects, UnknownNamesAreErrors) {
  core::ConfigNode root = core::ConfigNode::parse("effects: {radation: on}\n", "s.yaml");
  read_scene(root, "s.yaml");
  EXPECT_THROW(root.finish(), core::ConfigError);
}

}  // namespace
}  // namespace carillon::scene
