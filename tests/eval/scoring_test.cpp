// What anyone answers for a test set: how a board ranks it, and that seals hide what they hide.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "core/json.hpp"
#include "core/temporary_folder.hpp"
#include "dataset/exporters/seal.hpp"
#include "eval/scoring/class_board.hpp"
#include "eval/scoring/object_entry.hpp"

namespace carillon::eval::scoring {
namespace {

/// So many objects, of three sounds each, of two classes by turns.
TestSet test_set(std::size_t objects) {
  TestSet set;
  set.dataset = "bells";
  set.content = "hash";
  set.task = task_of_column("material");
  set.classes = {"brass", "steel"};
  for (std::size_t i = 0; i < 3 * objects; ++i) {
    set.asked.keys.push_back("bell-" + std::to_string(i));
    set.asked.labels.push_back(static_cast<std::int32_t>(i / 3 % 2));
    set.asked.objects.push_back(static_cast<std::uint32_t>(i / 3));
    set.asked.strikes.push_back(static_cast<std::uint32_t>(i));
    set.row_of[set.asked.keys.back()] = i;
  }
  return set;
}

core::CsvTable table_of(const TestSet& set, const std::function<bool(std::size_t)>& is_right) {
  core::CsvTable table{{"answers.csv:1", {"sample", "class"}}, {}};
  for (std::size_t i = 0; i < set.asked.samples(); ++i) {
    const auto label = static_cast<std::size_t>(set.asked.labels[i]);
    table.rows.push_back({"answers.csv:" + std::to_string(i + 2),
                          {set.asked.keys[i], set.classes[is_right(i) ? label : 1 - label]}});
  }
  return table;
}

class Boards : public testing::Test {
 protected:
  void hand_in(const std::string& name, const std::function<bool(std::size_t)>& is_right) {
    const ClassEntry entry = read_class_entry(table_of(set_, is_right), name, set_);
    keep_entry(entry, set_, entries_folder(folder_.path(), "material") / name);
  }
  Leaderboard board() const { return class_board(folder_.path(), folder_ / "none", set_); }

  TestSet set_ = test_set(40);
  core::TemporaryFolder folder_;
};

TEST_F(Boards, TellApartWhatDiffersOnTheSameSamples) {
  // The second misses what the first misses, and four objects more; the third misses others alone.
  hand_in("first", [](std::size_t i) { return i / 3 % 4 != 0; });
  hand_in("second", [](std::size_t i) { return i / 3 % 4 != 0 && i / 3 >= 18; });
  hand_in("third", [](std::size_t i) { return i / 3 % 4 != 1 || i / 3 == 1; });
  const Leaderboard found = board();
  ASSERT_EQ(found.rows.size(), 3u);
  EXPECT_EQ(found.rows[0].entry, "third");
  EXPECT_EQ(found.rows[1].entry, "first");
  EXPECT_FALSE(found.rows[1].is_told_apart) << "30 and 31 of 40 objects";
  EXPECT_EQ(found.rows[2].entry, "second");
  EXPECT_TRUE(found.rows[2].is_told_apart);
  EXPECT_NEAR(found.rows[2].difference->mean,
              found.rows[2].measures[0].estimate.mean - found.rows[0].measures[0].estimate.mean,
              1e-12);
}

TEST_F(Boards, TellEntriesApartThatDifferAlikeOnEveryObject) {
  hand_in("right", [](std::size_t) { return true; });
  hand_in("third-wrong", [](std::size_t i) { return i % 3 != 0; });
  const Leaderboard found = board();
  EXPECT_EQ(found.rows[1].entry, "third-wrong");
  EXPECT_TRUE(found.rows[1].is_told_apart) << "40 of 40 objects say so";
}

TEST_F(Boards, HaveTheLastAnswersOfAName) {
  hand_in("mine", [](std::size_t) { return false; });
  hand_in("mine", [](std::size_t) { return true; });
  const Leaderboard found = board();
  ASSERT_EQ(found.rows.size(), 1u);
  EXPECT_EQ(found.rows[0].measures[0].estimate.mean, 1);
  std::size_t files = 0;
  const std::filesystem::path place = entries_folder(folder_.path(), "material") / "mine";
  for ([[maybe_unused]] const auto& file : std::filesystem::directory_iterator(place)) ++files;
  EXPECT_EQ(files, 2u) << "entry.json and one file of answers";
}

TEST_F(Boards, LeaveOutWhatAnsweredForAnotherStateAndSayIt) {
  hand_in("right", [](std::size_t) { return true; });
  set_ = test_set(41);
  const Leaderboard found = board();
  EXPECT_TRUE(found.rows.empty());
  ASSERT_EQ(found.notes.size(), 1u);
  EXPECT_NE(found.notes[0].find("another state of the dataset"), std::string::npos);
}

TEST_F(Boards, HoldAThousandEntries) {
  set_ = test_set(10);
  const std::filesystem::path entries = entries_folder(folder_.path(), "material");
  constexpr int kept = 40, all = 1000;
  for (int e = 0; e < kept; ++e) {
    hand_in("entry-" + std::to_string(e), [e](std::size_t i) { return static_cast<int>(i) < e; });
  }
  // The others are copies of these: each that is kept durably takes the disk 20 ms.
  for (int e = kept; e < all; ++e) {
    const std::string name = "entry-" + std::to_string(e);
    std::filesystem::copy(entries / ("entry-" + std::to_string(e % kept)), entries / name);
    nlohmann::json about = core::read_json(entries / name / "entry.json");
    about["entry"] = name;
    std::ofstream(entries / name / "entry.json") << about;
  }
  const Leaderboard found = board();
  EXPECT_EQ(found.rows.size(), 1000u);
  EXPECT_TRUE(
      std::is_sorted(found.rows.begin(), found.rows.end(), [](const auto& a, const auto& b) {
        return a.measures[0].estimate.mean > b.measures[0].estimate.mean;
      }));
}

RC_GTEST_PROP(ClassEntries, AnswersComeBackWhateverTheirOrder, ()) {
  const TestSet set = test_set(5);
  const auto right = *rc::gen::container<std::vector<bool>>(15, rc::gen::arbitrary<bool>());
  core::CsvTable table = table_of(set, [&](std::size_t i) { return right[i]; });
  std::rotate(table.rows.begin(), table.rows.begin() + *rc::gen::inRange(0, 15), table.rows.end());
  const ClassEntry entry = read_class_entry(table, "any", set);
  const auto share = static_cast<double>(std::count(right.begin(), right.end(), true)) / 15;
  const auto found =
      answers_of(entry, set).summary(classification::AccuracyKind::plain, "any").value();
  RC_ASSERT(std::abs(found.mean - share) < 1e-12);
}

/// Two shapes, one in two materials.
TrueObjects true_objects() {
  const auto object = [](const std::string& shape, const std::string& material) {
    return TrueObject{shape + "/" + material + "/1", {1e6, 4e6, 9e6}, {}, {5, 6, 7}, {2, 1e-6}};
  };
  return {"bells",
          {object("bell-0", "brass"), object("bell-0", "steel"), object("bell-1", "steel")},
          {{"bell-0/brass/1/strike-0000", 0}}};
}

core::CsvTable object_table(std::vector<std::string> head,
                            const std::vector<std::vector<std::string>>& rows) {
  core::CsvTable table{{"fits.csv:1", std::move(head)}, {}};
  for (const auto& row : rows) {
    table.rows.push_back({"fits.csv:" + std::to_string(table.rows.size() + 2), row});
  }
  return table;
}

TEST(ObjectEntries, ErrorsAreThoseOfTheModes) {
  // c = 2 d = 10, 12, 14: 10 + 0 lambda gives errors 0, 1/6, 2/7.
  const core::CsvTable table = object_table(
      {"object", "alpha1", "alpha2"},
      {{"bell-0/brass", "10", "0"}, {"bell-0/steel/1", "10", "0"}, {"bell-1", "10", "0"}});
  const ObjectEntry entry = score_objects(table, "flat", ObjectTask::damping, true_objects());
  EXPECT_EQ(entry.objects.size(), 3u);
  EXPECT_NEAR(entry.measures[0].values[2], 1.0 / 6, 1e-12);
  EXPECT_NEAR(entry.measures[1].values[2], 4, 1e-12);
  EXPECT_NEAR(entry.measures[2].values[2], 1, 1e-12);
}

TEST(ObjectEntries, WhatDoesNotDecayHasNoRelativeError) {
  TrueObjects truth = true_objects();
  truth.objects[0].decay_rates = {0, 0, 0};
  truth.objects[2].decay_rates = {0, 6, 7};
  const core::CsvTable table = object_table(
      {"object", "alpha1", "alpha2"},
      {{"bell-0/brass", "12", "0"}, {"bell-0/steel/1", "12", "0"}, {"bell-1", "12", "0"}});
  const ObjectEntry entry = score_objects(table, "flat", ObjectTask::damping, truth);
  EXPECT_TRUE(std::isnan(entry.measures[0].values[0]));
  EXPECT_NEAR(entry.measures[0].values[2], (0 + 1.0 / 7) / 2, 1e-12);
  // Entries are compared shape by shape, and one without a number stands in nobody's way.
  const core::TemporaryFolder folder;
  for (const char* name : {"one", "two"}) {
    ObjectEntry named = entry;
    named.name = name;
    keep_entry(named, entries_folder(folder.path(), "damping") / name);
  }
  const Leaderboard found = object_board(folder.path(), ObjectTask::damping, truth);
  ASSERT_EQ(found.rows.size(), 2u);
  EXPECT_FALSE(found.rows[1].is_told_apart);
}

TEST(ObjectEntries, AModeIsAnsweredOnce) {
  // Two answers for the first mode, one for the third.
  const core::CsvTable table =
      object_table({"object", "frequency_hz"}, {{"bell-0/brass", "159.1549"},
                                                {"bell-0/brass", "159.2"},
                                                {"bell-0/brass", "477.4648"},
                                                {"bell-0/steel", "159.1549"},
                                                {"bell-1", "159.1549"}});
  const ObjectEntry entry = score_objects(table, "few", ObjectTask::modes, true_objects());
  EXPECT_NEAR(entry.measures[0].values[0], 0, 1e-2) << "0, 100 and 0 cents";
  EXPECT_NEAR(entry.measures[1].values[0], 2.0 / 3, 1e-12);
  EXPECT_NEAR(entry.measures[2].values[0], 1.0 / 3, 1e-12);
  EXPECT_NEAR(entry.measures[0].values[1], 100, 1e-12) << "0, 100 and 100 cents";
}

TEST(ObjectEntries, WhatIsWrongIsNamed) {
  const auto refusal = [](std::vector<std::string> head,
                          const std::vector<std::vector<std::string>>& rows) {
    try {
      score_objects(object_table(std::move(head), rows), "wrong", ObjectTask::damping,
                    true_objects());
    } catch (const core::InputError& error) {
      return error.message();
    }
    return std::string("nothing is wrong");
  };
  const std::vector<std::string> law = {"object", "alpha1", "alpha2"};
  EXPECT_NE(refusal(law, {{"bell-0", "1", "1"}}).find("is any of 2 objects"), std::string::npos);
  EXPECT_NE(refusal(law, {{"bell-2", "1", "1"}}).find("fits.csv:2: no object \"bell-2\""),
            std::string::npos);
  EXPECT_NE(refusal(law, {{"bell-1", "1", "1"}}).find("2 of 3 objects"), std::string::npos);
  EXPECT_NE(
      refusal(law, {{"bell-1", "x", "1"}, {"bell-0/brass", "1", "1"}, {"bell-0/steel", "1", "1"}})
          .find("alpha1 \"x\" is no number"),
      std::string::npos);
  EXPECT_NE(refusal(law, {{"bell-1", "1", "1"},
                          {"bell-1", "1", "1"},
                          {"bell-0/brass", "1", "1"},
                          {"bell-0/steel", "1", "1"}})
                .find("one object twice"),
            std::string::npos);
  EXPECT_NE(refusal({"object", "alpha1"}, {}).find("either alpha1 and alpha2"), std::string::npos);
  EXPECT_NE(refusal({"alpha1", "alpha2"}, {}).find("says what each row is of"), std::string::npos);
}

TEST(Seals, NamesTellNothingWithoutTheSecret) {
  const std::vector<std::string> keys = {"a/steel/1/strike-0000", "a/wood/1/strike-0000"};
  const auto one = dataset::exporters::make_seal("split_shape", {"test"}, keys);
  const auto other = dataset::exporters::make_seal("split_shape", {"test"}, keys);
  EXPECT_NE(one.id_of(keys[0]), one.id_of(keys[1]));
  EXPECT_NE(one.id_of(keys[0]), other.id_of(keys[0]));
  EXPECT_EQ(one.id_of(keys[0]).size(), 32u);
  EXPECT_TRUE(one.is_of(keys));
  EXPECT_FALSE(one.is_of(std::vector<std::string>{keys[0]}));
  const auto read = dataset::exporters::seal_from(nlohmann::json::parse(to_json(one).dump()));
  EXPECT_EQ(read.id_of(keys[1]), one.id_of(keys[1]));
  EXPECT_THROW(dataset::exporters::seal_from({{"secret", "x"}}), core::InputError);
}

TEST(Seals, AreOfTheKnownHash) {
  // RFC 4231, test case 2.
  EXPECT_EQ(core::hmac_sha256("Jefe", "what do ya want for nothing?"),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
}

}  // namespace
}  // namespace carillon::eval::scoring
