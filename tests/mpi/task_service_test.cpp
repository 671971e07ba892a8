#include "mpi/task_service.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <new>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <thread>

#include "core/data_limit.hpp"
#include "core/error.hpp"
#include "core/sanitizers.hpp"
#include "core/temporary_folder.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/process_memory.hpp"
#include "mpi/running_task.hpp"
#include "tests/mpi/busy.hpp"

namespace carillon::mpi {
namespace {

const MPI_Comm world = MPI_COMM_WORLD;

/// n tasks on rank 0, none elsewhere, as a build does it.
TaskBoard board_of(int n) {
  std::vector<Task> tasks;
  for (int i = 0; rank(world) == 0 && i < n; ++i) tasks.push_back({.key = std::to_string(i)});
  return TaskBoard(std::move(tasks));
}

/// Numbers of all ranks, joined in rank order.
std::vector<std::int64_t> gather(const std::vector<std::int64_t>& mine) {
  std::ostringstream text;
  for (const std::int64_t number : mine) text << number << ' ';
  std::vector<std::int64_t> all;
  for (const std::string& part : all_gather(text.str(), world)) {
    std::istringstream in(part);
    for (std::int64_t number = 0; in >> number;) all.push_back(number);
  }
  return all;
}

std::vector<std::int64_t> work_off(TaskService& service) {
  std::vector<std::int64_t> mine;
  for (Claim claim = service.next(1); claim.kind == Claim::Kind::task; claim = service.next(1)) {
    mine.push_back(claim.task);
    service.complete(claim.task, {});
  }
  return mine;
}

TEST(TaskService, EveryTaskGoesToOneRank) {
  TaskService service(world, board_of(200), {});
  std::vector<std::int64_t> all = gather(work_off(service));
  std::sort(all.begin(), all.end());
  ASSERT_EQ(all.size(), 200U);
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i], static_cast<std::int64_t>(i));
  const TaskService::End end = service.finish();
  EXPECT_FALSE(end.stopped);
  EXPECT_EQ(end.board.count(TaskState::done), rank(world) == 0 ? 200 : 0);
  EXPECT_THROW(service.next(1), core::Error);
}

TEST(TaskService, AnEmptyBoardEndsAtOnce) {
  TaskService service(world, board_of(0), {});
  EXPECT_EQ(service.next(1).kind, Claim::Kind::end);
  service.finish();
}

TEST(TaskService, EndsWithoutBeingFinished) {
  TaskService service(world, board_of(10), {});
  if (rank(world) == 0) work_off(service);
}

/// The host computes under a limit of its own while the others report.
TEST(TaskService, TheHostsLimitOfMemoryIsNoneForTheService) {
  if (core::address_sanitizer) GTEST_SKIP() << "AddressSanitizer knows no limits of memory";
  std::size_t length = 0;
  const ServiceHooks hooks{
      .completed = [&](const Task&, const Outcome& outcome) { length += outcome.record.size(); }};
  TaskService service(world, board_of(1), hooks);
  const std::size_t wanted = 40'000'000;
  int all_done = 0;
  std::optional<core::DataLimit> limit;
  if (rank(world) == 0) limit.emplace(process_memory().data + (1 << 20));
  MPI_Barrier(world);
  if (rank(world) == size(world) - 1 && rank(world) > 0) {
    const Claim claim = service.next(1);
    service.complete(claim.task, {true, std::string(wanted, 'x')});
    all_done = 1;
  }
  MPI_Allreduce(MPI_IN_PLACE, &all_done, 1, MPI_INT, MPI_MAX, world);
  if (rank(world) == 0) {
    EXPECT_THROW(::operator delete(::operator new(wanted)), std::bad_alloc)
        << "the limit holds for the host";
  }
  limit.reset();
  service.finish();
  EXPECT_EQ(length, rank(world) == 0 && size(world) > 1 ? wanted : 0);
}

TEST(TaskService, RecordsOfAnyLengthReachTheHook) {
  std::set<std::size_t> lengths;
  const ServiceHooks hooks{.completed = [&](const Task&, const Outcome& outcome) {
    lengths.insert(outcome.record.size());
  }};
  const std::vector<std::size_t> wanted{0, 1, 5'000, 300'000, 3'000'000};
  TaskService service(world, board_of(static_cast<int>(wanted.size())), hooks);
  // The last rank brings them all: by messages wherever there are others.
  for (int i = 0; rank(world) == size(world) - 1 && i < 5; ++i) {
    const Claim claim = service.next(1);
    service.complete(claim.task, {true, std::string(wanted[static_cast<std::size_t>(i)], 'x')});
  }
  service.finish();
  if (rank(world) == 0) {
    EXPECT_EQ(lengths, std::set<std::size_t>(wanted.begin(), wanted.end()));
  }
}

/// Where the main thread blocks SIGTERM, as it does around METIS, no other must take it: neither
/// MPI's nor ours.
TEST(TaskService, NoThreadBesideTheMainOneTakesSigterm) {
  const InterruptGuard guard({.last_words = {}});
  const core::TemporaryFolder folder;
  const RunningTask running(folder.path() / "rank", 77);
  TaskService service(world, board_of(1), {});
  // A thread begins with every signal blocked.
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  constexpr std::uint64_t of_sigterm = std::uint64_t{1} << (SIGTERM - 1);
  int others = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    if (entry.path().filename() == std::to_string(getpid())) continue;
    ++others;
    std::ifstream status(entry.path() / "status");
    for (std::string line; std::getline(status, line);) {
      if (!line.starts_with("SigBlk:")) continue;
      EXPECT_NE(std::stoull(line.substr(7), nullptr, 16) & of_sigterm, 0U) << entry.path();
    }
  }
  EXPECT_GT(others, rank(world) == 0 ? 1 : 0);
}

TEST(TaskService, AnyRankCanStopIt) {
  TaskService service(world, board_of(1000), {});
  const Claim claim = service.next(1);
  EXPECT_EQ(claim.kind, Claim::Kind::task);
  MPI_Barrier(world);
  if (rank(world) == size(world) - 1) service.stop();
  MPI_Barrier(world);
  EXPECT_EQ(service.next(1).kind, Claim::Kind::end);
  service.complete(claim.task, {});
  const TaskService::End end = service.finish();
  EXPECT_TRUE(end.stopped);
  if (rank(world) == 0) {
    EXPECT_EQ(end.board.count(TaskState::done), size(world));
  }
}

TEST(TaskService, AnExceptionInAHookReachesEveryRank) {
  int calls = 0;
  const ServiceHooks hooks{.completed = [&](const Task&, const Outcome&) {
    if (++calls == 5) throw core::FileError("disk full", "make room");
  }};
  TaskService service(world, board_of(100), hooks);
  const std::size_t mine = work_off(service).size();
  EXPECT_LE(mine, 5U);
  try {
    service.finish();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const core::FileError& e) {
    EXPECT_EQ(e.message(), "disk full");
    EXPECT_EQ(e.hint(), "make room");
  }
}

TEST(TaskService, AnswersWhileItsHostComputes) {
  if (size(world) == 1) GTEST_SKIP() << "needs a second rank";
  TaskService service(world, board_of(50 * size(world)), {});
  MPI_Barrier(world);
  const double begin = core::monotonic_seconds();
  std::vector<double> seconds;
  if (rank(world) == 0) compute_for(0.7);
  for (int i = 0; rank(world) != 0 && i < 50; ++i) {
    const double start = core::monotonic_seconds();
    service.complete(service.next(1).task, {});
    // Later ones may have been answered with the host at rest.
    if (start - begin < 0.5) seconds.push_back((core::monotonic_seconds() - start) / 2);
    sleep_for(0.003);  // as if there were work: the service falls asleep meanwhile
  }
  std::sort(seconds.begin(), seconds.end());
  double figures[2]{};
  if (rank(world) != 0) {
    EXPECT_GE(seconds.size(), 5U);
    seconds.push_back(seconds.empty() ? 1 : seconds.back());
    figures[0] = seconds[seconds.size() / 2];
    figures[1] = seconds.back();
    // Milliseconds on a free machine; the bound allows for one that runs much else.
    EXPECT_LT(figures[0], 0.1);
  }
  MPI_Allreduce(MPI_IN_PLACE, figures, 2, MPI_DOUBLE, MPI_MAX, world);
  if (rank(world) == 0) {
    std::printf("an answer takes %.2f ms (median of the slowest rank), at most %.2f ms\n",
                1e3 * figures[0], 1e3 * figures[1]);
  }
  service.finish();
}

TEST(TaskService, CostsNothingWhileNobodyAsks) {
  TaskService service(world, board_of(1), {});
  MPI_Barrier(world);
  const double before = processor_seconds();
  sleep_for(1);
  const double used = processor_seconds() - before;
  if (rank(world) == 0) std::printf("an idle service takes %.2f %% of a core\n", 100 * used);
  EXPECT_LT(used, 0.05);
  service.finish();
}

TEST(TaskService, WaitingForOtherTasksCostsNothing) {
  if (size(world) == 1) GTEST_SKIP() << "needs a second rank";
  std::vector<Task> tasks{{.key = "modes"}, {.key = "samples", .after = {0}}};
  TaskService service(world, rank(world) == 0 ? TaskBoard(tasks) : TaskBoard(), {});
  if (rank(world) == 0) {
    EXPECT_EQ(service.next(1).task, 0);
    MPI_Barrier(world);
    sleep_for(0.5);
    service.complete(0, {});
  } else {
    MPI_Barrier(world);
    const double before = processor_seconds();
    const Claim claim = service.next(1);
    EXPECT_LT(processor_seconds() - before, 0.1);
    if (claim.kind == Claim::Kind::task) service.complete(claim.task, {});
  }
  const TaskService::End end = service.finish();
  if (rank(world) == 0) {
    EXPECT_EQ(end.board.count(TaskState::done), 2);
  }
}

}  // namespace
}  // namespace carillon::mpi
