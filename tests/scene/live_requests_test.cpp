#include <gtest/gtest.h>

#include <array>
#include <string>

#include "core/error.hpp"
#include "scene/live/midi.hpp"
#include "scene/live/request.hpp"

namespace carillon::scene {
namespace {

using live::Request;

TEST(LiveRequests, LinesSayWhatHappens) {
  const auto strike = live::parse_request(
      "0.250 strike bell position 0 1cm 0.05 direction 0 0 -2 impulse 0.02 contact 1ms # loud");
  ASSERT_TRUE(strike);
  EXPECT_EQ(strike->kind, Request::Kind::strike);
  EXPECT_DOUBLE_EQ(*strike->time, 0.25);
  EXPECT_EQ(strike->object, "bell");
  EXPECT_EQ(*strike->position, Vec3(0, 0.01, 0.05));
  EXPECT_EQ(*strike->direction, Vec3(0, 0, -2));
  EXPECT_DOUBLE_EQ(*strike->impulse, 0.02);
  EXPECT_DOUBLE_EQ(*strike->contact, 1e-3);
  const auto support = live::parse_request("- support 0 2 stiffness 1000 damping 3");
  ASSERT_TRUE(support);
  EXPECT_FALSE(support->time);
  EXPECT_EQ(support->support, 2);
  EXPECT_DOUBLE_EQ(*support->stiffness, 1000);
  EXPECT_DOUBLE_EQ(*support->damping, 3);
  EXPECT_FALSE(support->on);
  EXPECT_EQ(live::parse_request("1 support bell 0 off")->on, false);
  EXPECT_DOUBLE_EQ(live::parse_request("1 damp * 30")->amount, 30);
  EXPECT_EQ(live::parse_request("1 stop\r\n")->kind, Request::Kind::stop);
  EXPECT_FALSE(live::parse_request("  # nothing"));
  EXPECT_FALSE(live::parse_request(""));
}

TEST(LiveRequests, MalformedLinesAreRefused) {
  for (const char* line :
       {"x", "1", "-1 stop", "1 stop now", "nan stop", "1 hit bell", "1 strike", "1 strike a b",
        "1 strike a position 1 2", "1 strike a impulse loud", "1 strike a contact 1kg",
        "1 support a", "1 support a b on", "1 support a 0", "1 support a -1 on", "1 damp a",
        "1 support a 99999999999999999999 on", "1 damp a inf"}) {
    EXPECT_THROW(live::parse_request(line), core::InputError) << line;
  }
}

TEST(LiveRequests, NotesStrikeAndThePedalTakesTheHandOff) {
  const auto ask = [](std::array<std::uint8_t, 3> message, std::size_t objects) {
    return live::midi_request(message, objects, 50);
  };
  const auto note = ask({0x93, 38, 50}, 5);
  ASSERT_TRUE(note);
  EXPECT_EQ(note->object, "2");
  EXPECT_DOUBLE_EQ(note->strength, 0.25);
  EXPECT_EQ(ask({0x90, 40, 100}, 1)->place, 4);
  EXPECT_FALSE(ask({0x90, 41, 100}, 5));
  EXPECT_FALSE(ask({0x90, 35, 100}, 5));
  EXPECT_FALSE(ask({0x90, 36, 0}, 5));
  EXPECT_FALSE(ask({0x80, 36, 64}, 5));
  EXPECT_DOUBLE_EQ(ask({0xB0, 64, 127}, 5)->amount, 0);
  EXPECT_DOUBLE_EQ(ask({0xB0, 64, 0}, 5)->amount, 50);
  EXPECT_DOUBLE_EQ(ask({0xB0, 1, 127}, 5)->amount, 50);
  EXPECT_FALSE(ask({0xB0, 7, 127}, 5));
  EXPECT_FALSE(ask({0x90, 200, 100}, 1));
  EXPECT_FALSE(live::midi_request({}, 1, 50));
}

}  // namespace
}  // namespace carillon::scene
