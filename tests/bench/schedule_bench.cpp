// What the machinery around tasks costs: the figures of docs/scaling.md. Runs under mpirun.
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "core/files.hpp"
#include "core/trace.hpp"
#include "mpi/comm.hpp"
#include "mpi/journal.hpp"
#include "mpi/simulation.hpp"
#include "mpi/task_service.hpp"

namespace carillon::mpi {
namespace {

const MPI_Comm world = MPI_COMM_WORLD;

std::vector<Task> many(int n) {
  std::vector<Task> tasks;
  for (int i = 0; i < n; ++i) {
    tasks.push_back({.key = std::to_string(i), .cost = static_cast<double>(i % 97)});
  }
  return tasks;
}

/// Seconds of each of `times` calls, sorted.
template <class Work>
std::vector<double> timed(int times, const Work& work) {
  std::vector<double> seconds;
  for (int i = 0; i < times; ++i) {
    const double start = core::monotonic_seconds();
    work(i);
    seconds.push_back(core::monotonic_seconds() - start);
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds;
}

void print(const char* name, const std::vector<double>& seconds) {
  const std::size_t n = seconds.size();
  fmt::print("{:<46} median {:9.1f} us   9 of 10 below {:9.1f} us\n", name, 1e6 * seconds[n / 2],
             1e6 * seconds[n * 9 / 10]);
}

/// A line such as a task of 256 sounds leaves.
nlohmann::json journal_line(int i) {
  nlohmann::json line = {{"task", fmt::format("samples/bowl-{:04}", i)}, {"ok", true}};
  line["files"].push_back({{"path", fmt::format("samples/bowl-{:04}.h5", i)},
                           {"sha256", std::string(64, 'a')},
                           {"bytes", 46137344}});
  for (const char* stage : {"read modes", "contact", "radiation", "room", "noise", "write shard"}) {
    line["trace"]["stages"][stage] = {{"calls", 256}, {"seconds", 0.123456789}};
  }
  return line;
}

void board() {
  const int n = 200000;
  TaskHost host(TaskBoard(many(n)), {});
  const double start = core::monotonic_seconds();
  for (int i = 0; i < n; ++i) host.complete(host.claim(1).task, {});
  fmt::print("{:<46} {:.2f} us for a claim and a completion\n", "the board alone, 200,000 tasks",
             1e6 * (core::monotonic_seconds() - start) / n);
}

/// All ranks but the host ask and complete as fast as they are answered.
void requests_per_second(const std::filesystem::path& folder, bool journal) {
  const int n = journal ? 400 : 20000;
  const bool host = rank(world) == 0;
  std::unique_ptr<Journal> lines;
  if (host && journal) lines = std::make_unique<Journal>(folder / "rate.jsonl");
  ServiceHooks hooks;
  if (journal) {
    hooks.completed = [&, i = 0](const Task&, const Outcome&) mutable {
      lines->append(journal_line(i++));
    };
  }
  TaskService service(world, host ? TaskBoard(many(n)) : TaskBoard(), hooks);
  const double start = core::monotonic_seconds();
  if (!host) {
    for (Claim claim = service.next(1); claim.kind == Claim::Kind::task; claim = service.next(1)) {
      service.complete(claim.task, {});
    }
  }
  service.finish();
  const double seconds = core::monotonic_seconds() - start;
  if (host) {
    fmt::print("{:<46} {:.0f} tasks/s ({:.1f} us each)\n",
               fmt::format("{} ranks ask {}", size(world) - 1, journal ? "with journal" : "alone"),
               n / seconds, 1e6 * seconds / n);
  }
}

/// A rank asks a host that has rested.
void answer_at_rest() {
  const int n = 100;
  const bool host = rank(world) == 0;
  TaskService service(world, host ? TaskBoard(many(n)) : TaskBoard(), {});
  if (rank(world) == 1) {
    std::vector<double> seconds;
    for (int i = 0; i < n; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(37));
      const auto one = timed(1, [&](int) { service.next(1); });
      seconds.push_back(one.front());
    }
    std::sort(seconds.begin(), seconds.end());
    print("a question and its answer, the service at rest", seconds);
  }
  service.finish();
}

void files(const std::filesystem::path& folder) {
  Journal journal(folder / "journal.jsonl");
  print("journal: a line, synced", timed(300, [&](int i) { journal.append(journal_line(i)); }));
  print("a small file written durably", timed(300, [&](int i) {
          core::write_text_durably(folder / "files" / fmt::format("{}.txt", i), "text");
        }));
}

void simulation() {
  const int n = 1000000;
  TaskBoard tasks(many(n));
  std::vector<double> seconds(n, 1.0);
  const double start = core::monotonic_seconds();
  simulate(std::move(tasks), seconds, {.ranks = 4096});
  fmt::print("{:<46} {:.2f} s\n", "simulated: 1,000,000 tasks on 4,096 ranks",
             core::monotonic_seconds() - start);
}

}  // namespace
}  // namespace carillon::mpi

int main(int argc, char** argv) {
  using namespace carillon::mpi;
  const Environment environment(argc, argv);
  const bool host = rank(MPI_COMM_WORLD) == 0;
  const std::filesystem::path folder = argc > 1 ? argv[1] : ".";
  if (host) {
    board();
    files(folder);
    simulation();
  }
  MPI_Barrier(MPI_COMM_WORLD);
  if (size(MPI_COMM_WORLD) > 1) {
    requests_per_second(folder, false);
    requests_per_second(folder, true);
    answer_at_rest();
  }
  return 0;
}
