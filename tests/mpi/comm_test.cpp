#include "mpi/comm.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <ctime>
#include <functional>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/error.hpp"
#include "mpi/failure.hpp"

namespace carillon::mpi {
namespace {

const MPI_Comm world = MPI_COMM_WORLD;

TEST(Comm, EveryTextArrivesWhole) {
  const std::string odd("a\0b", 3);
  for (const std::string& text : {std::string(), odd, std::string(300'000, 'x')}) {
    for (int root = 0; root < size(world); ++root) {
      EXPECT_EQ(broadcast(rank(world) == root ? text : "not mine", root, world), text);
    }
  }
}

TEST(Comm, GatheredTextsKeepRankOrder) {
  // Rank r brings r * r letters, so that some are empty and none has its neighbour's length.
  const auto text_of = [](int r) {
    return std::string(static_cast<std::size_t>(r * r), static_cast<char>('a' + r));
  };
  const std::vector<std::string> texts = all_gather(text_of(rank(world)), world);
  ASSERT_EQ(texts.size(), static_cast<std::size_t>(size(world)));
  for (int r = 0; r < size(world); ++r) EXPECT_EQ(texts[static_cast<std::size_t>(r)], text_of(r));
}

TEST(Comm, ADuplicateIsFreedOnceAndNoGroupIsNoTrouble) {
  Comm first = duplicate(world);
  Comm second = std::move(first);
  EXPECT_EQ(size(second.get()), size(world));
  Comm none;
  MPI_Comm_split(world, MPI_UNDEFINED, 0, none.put());
  EXPECT_EQ(none.get(), MPI_COMM_NULL);
}

TEST(Agree, SilenceIsAgreement) {
  EXPECT_NO_THROW(agreed(world, [] {}));
}

TEST(Agree, EveryRankThrowsTheLowestFailingRanksError) {
  for (int lowest = 0; lowest < size(world); ++lowest) {
    try {
      agreed(world, [&] {
        if (rank(world) >= lowest) {
          throw core::InputError("broken on " + std::to_string(rank(world)), "mend it");
        }
      });
      ADD_FAILURE() << "nothing was thrown";
    } catch (const core::InputError& e) {
      EXPECT_EQ(e.message(), "broken on " + std::to_string(lowest));
      EXPECT_EQ(e.hint(), "mend it");
    }
  }
}

template <class Thrown, class Expected>
void expect_kept_on_all_ranks(const Thrown& thrown, const std::string& message) {
  const int failing = size(world) - 1;
  try {
    agreed(world, [&] {
      if (rank(world) == failing) throw thrown;
    });
    ADD_FAILURE() << "nothing was thrown";
  } catch (const core::Error& e) {
    EXPECT_EQ(typeid(e), typeid(Expected));
    EXPECT_EQ(e.message(), message);
  }
}

TEST(Agree, KeepsTheKindOfTheError) {
  using namespace core;
  expect_kept_on_all_ranks<ConfigError, ConfigError>(ConfigError("a.yaml:1:2: x"), "a.yaml:1:2: x");
  expect_kept_on_all_ranks<InputError, InputError>(InputError("a hole"), "a hole");
  expect_kept_on_all_ranks<SolverError, SolverError>(SolverError("no way"), "no way");
  expect_kept_on_all_ranks<FileError, FileError>(FileError("disk full"), "disk full");
  expect_kept_on_all_ranks<Error, Error>(Error("plain \xff"), "plain \xef\xbf\xbd");
  expect_kept_on_all_ranks<std::out_of_range, Error>(std::out_of_range("range"), "range");
  expect_kept_on_all_ranks<TimeError, TimeError>(TimeError("late"), "late");
  expect_kept_on_all_ranks<MemoryError, MemoryError>(MemoryError("full"), "full");
  expect_kept_on_all_ranks<std::bad_alloc, MemoryError>(std::bad_alloc(), "out of memory");
  expect_kept_on_all_ranks<int, Error>(7, "an unknown exception");
}

std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const core::Error& e) {
    return e.message();
  }
  return "";
}

/// The last rank fails where nobody asks it, the others are on their way through three stages.
TEST(Agree, AnErrorBetweenStagesReachesAllAtTheEnd) {
  const bool failing = rank(world) == size(world) - 1;
  for (int again = 0; again < 3; ++again) {
    int passed = 0;
    const auto task = [&] {
      if (failing) throw core::InputError("fell over");
      agreed(world, [&] {
        for (; passed < 3; ++passed) agreed(world, [] {});
      });
    };
    EXPECT_EQ(message_of([&] { agree_at_end(world, error_of(task)); }), "fell over");
    EXPECT_EQ(passed, 0);
    EXPECT_EQ(message_of([&] { agree_at_end(world, nullptr); }), "");
  }
}

/// Run alone, as it ends the process (CMakeLists.txt).
TEST(Agree, DISABLED_WhoWaitsInVainCrashes) {
  if (rank(world) > 0) MPI_Barrier(world);
  const auto fall = error_of([] { throw core::InputError("fell over"); });
  agree_at_end(world, fall, 0.5);
}

TEST(Agree, WaitingForALateRankCostsNoCore) {
  timespec before{};
  timespec after{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &before);
  agreed(world, [] {
    if (rank(world) == 0) std::this_thread::sleep_for(std::chrono::milliseconds(400));
  });
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &after);
  const double used = static_cast<double>(after.tv_sec - before.tv_sec) +
                      1e-9 * static_cast<double>(after.tv_nsec - before.tv_nsec);
  EXPECT_LT(used, 0.1);
}

TEST(Failure, RecordIsOneLineOfJson) {
  const Failure failure{"SolverError", "two\nlines \"quoted\"", "a hint"};
  const std::string record = to_record(failure);
  EXPECT_EQ(record.find('\n'), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(record).at("kind"), "SolverError");
  EXPECT_EQ(from_record(record), failure);
  EXPECT_EQ(to_record({"Error", "m", ""}), R"({"kind":"Error","message":"m"})");
  const Failure staged{"FileError", "disk full", "", "write", "bar/steel/1/strike-0001"};
  EXPECT_EQ(from_record(to_record(staged)), staged);
  const Failure passing{"LimitError", "no room now", "", "", "", false};
  EXPECT_EQ(from_record(to_record(passing)), passing);
  EXPECT_EQ(to_record(staged).find("lasting"), std::string::npos);
  try {
    raise(staged);
  } catch (const TaskError&) {
    EXPECT_EQ(describe(std::current_exception()), staged);
  }
  EXPECT_THROW(from_record("{}"), core::Error);
  EXPECT_THROW(from_record("no json"), core::Error);
}

}  // namespace
}  // namespace carillon::mpi
