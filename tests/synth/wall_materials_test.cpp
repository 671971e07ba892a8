#include "synth/room/wall_materials.hpp"

#include <gtest/gtest.h>

#include <set>

#include "core/error.hpp"

namespace carillon::synth {
namespace {

TEST(WallMaterials, AreFractionsOfEnergyWithASource) {
  std::set<std::string> names;
  for (const room::WallMaterial& wall : room::wall_materials()) {
    EXPECT_TRUE(names.insert(wall.name).second) << wall.name;
    EXPECT_FALSE(wall.meaning.empty()) << wall.name;
    EXPECT_NE(wall.source.find(", "), std::string::npos) << wall.name;
    for (const double a : wall.absorption) {
      EXPECT_GT(a, 0) << wall.name;
      EXPECT_LE(a, 1) << wall.name;
    }
    EXPECT_EQ(wall.absorption[7], wall.absorption[6]) << wall.name;  // no table reaches 16 kHz
  }
  EXPECT_GE(names.size(), 25u);
}

// Rows of the two tables, as printed.
TEST(WallMaterials, AreTheTablesRows) {
  using Row = room::OctaveValues;
  EXPECT_EQ(room::find_wall_material("brick").absorption,
            (Row{0.03, 0.03, 0.03, 0.04, 0.05, 0.07, 0.07, 0.07}));
  EXPECT_EQ(room::find_wall_material("carpet_heavy").absorption,
            (Row{0.08, 0.24, 0.57, 0.69, 0.71, 0.73, 0.73, 0.73}));
  EXPECT_EQ(room::find_wall_material("wooden_door").absorption,
            (Row{0.14, 0.10, 0.06, 0.08, 0.10, 0.10, 0.10, 0.10}));
  EXPECT_EQ(room::find_wall_material("audience").absorption,
            (Row{0.24, 0.40, 0.78, 0.98, 0.96, 0.87, 0.87, 0.87}));
}

// What makes rooms sound as they do: a carpet takes treble, panels that swing take bass.
TEST(WallMaterials, AbsorbWhereTheyShould) {
  for (const char* name : {"carpet_thin", "carpet", "carpet_heavy", "curtains"}) {
    const room::OctaveValues& a = room::find_wall_material(name).absorption;
    EXPECT_GT(a[5], 3 * a[0]) << name;
  }
  for (const char* name : {"gypsum_board", "plasterboard", "plywood", "wood_panelling", "window"}) {
    const room::OctaveValues& a = room::find_wall_material(name).absorption;
    EXPECT_GT(a[0], 2 * a[4]) << name;
  }
  for (const char* name : {"concrete", "marble", "brick_painted", "water"}) {
    for (const double a : room::find_wall_material(name).absorption) EXPECT_LE(a, 0.05) << name;
  }
}

TEST(WallMaterials, AnUnknownNameNamesTheNearest) {
  const auto message = [](const std::string& name) -> std::string {
    try {
      room::find_wall_material(name);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message("brik").find("did you mean \"brick\"?"), std::string::npos);
  EXPECT_NE(message("glazing").find("did you mean \"double_glazing\"?"), std::string::npos);
}

TEST(Octaves, TheLastValueHoldsForThoseAbove) {
  const std::array<double, 6> six = {1, 2, 3, 4, 5, 6};
  EXPECT_EQ(room::octaves_of(six), (room::OctaveValues{1, 2, 3, 4, 5, 6, 6, 6}));
  EXPECT_THROW(room::octaves_of(std::span(six).first(5)), core::InputError);
  EXPECT_THROW(room::octaves_of(std::array<double, 9>{}), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
