#include "mpi/comm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <utility>

#include "core/error.hpp"
#include "core/termination_blocked.hpp"
#include "mpi/backoff.hpp"
#include "mpi/failure.hpp"

namespace carillon::mpi {

int free_comm(MPI_Comm* comm) {
  return *comm == MPI_COMM_NULL ? MPI_SUCCESS : MPI_Comm_free(comm);
}

Comm duplicate(MPI_Comm comm) {
  Comm copy;
  MPI_Comm_dup(comm, copy.put());
  return copy;
}

int rank(MPI_Comm comm) {
  int value = 0;
  MPI_Comm_rank(comm, &value);
  return value;
}

int size(MPI_Comm comm) {
  int value = 0;
  MPI_Comm_size(comm, &value);
  return value;
}

Environment::Environment(int& argc, char**& argv) {
  int running = 0;
  MPI_Initialized(&running);
  if (running != 0) throw core::Error("MPI has been started already in this process");
  int given = MPI_THREAD_SINGLE;
  const core::TerminationBlocked blocked;  // in MPI's threads
  MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &given);
  if (given < MPI_THREAD_MULTIPLE) {
    MPI_Finalize();
    throw core::Error("this MPI library does not let several threads communicate",
                      "use one that was built with MPI_THREAD_MULTIPLE, as Debian's Open MPI is");
  }
}

Environment::~Environment() {
  int ended = 0;
  MPI_Finalized(&ended);
  if (ended == 0) MPI_Finalize();
}

void broadcast(void* data, std::size_t bytes, int root, MPI_Comm comm) {
  auto* next = static_cast<std::byte*>(data);
  // Counts are int in MPI 3: more goes in pieces.
  while (bytes > 0) {
    const auto piece = std::min<std::size_t>(bytes, INT_MAX / 2);
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ibcast(next, static_cast<int>(piece), MPI_BYTE, root, comm, &request);
    wait_idly(request);
    next += piece;
    bytes -= piece;
  }
}

std::string broadcast(const std::string& text, int root, MPI_Comm comm) {
  std::uint64_t length = text.size();
  broadcast(&length, sizeof length, root, comm);
  std::string result = rank(comm) == root ? text : std::string(length, '\0');
  broadcast(result.data(), result.size(), root, comm);
  return result;
}

std::vector<std::string> all_gather(const std::string& text, MPI_Comm comm) {
  const auto ranks = static_cast<std::size_t>(size(comm));
  const std::uint64_t length = text.size();
  std::vector<std::uint64_t> lengths(ranks);
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallgather(&length, 1, MPI_UINT64_T, lengths.data(), 1, MPI_UINT64_T, comm, &request);
  wait_idly(request);
  const std::uint64_t total = std::accumulate(lengths.begin(), lengths.end(), std::uint64_t{0});
  if (total > INT_MAX) {
    throw core::Error(fmt::format("texts of {} bytes together are too long to gather", total));
  }
  std::vector<int> counts(lengths.begin(), lengths.end());
  std::vector<int> offsets(ranks, 0);
  std::partial_sum(counts.begin(), counts.end() - 1, offsets.begin() + 1);
  std::string joined(total, '\0');
  MPI_Iallgatherv(text.data(), counts[static_cast<std::size_t>(rank(comm))], MPI_CHAR,
                  joined.data(), counts.data(), offsets.data(), MPI_CHAR, comm, &request);
  wait_idly(request);
  std::vector<std::string> texts;
  texts.reserve(ranks);
  std::size_t begin = 0;
  for (const std::uint64_t bytes : lengths) {
    texts.push_back(joined.substr(begin, bytes));
    begin += bytes;
  }
  return texts;
}

namespace {

/// The part of a task that a rank agrees on.
enum Level : int { stage, end };

[[noreturn]] void leave_the_others(int rank, const std::exception_ptr& error) {
  std::fprintf(stderr, "carillon: rank %d: %s; the other ranks cannot go on without it\n", rank,
               describe(error).message.c_str());
  // A crash: the task stays noted as begun, and a job script runs the build again.
  std::abort();
}

/// @return the record of the lowest failing rank ("": none), and the least level of all ranks
std::pair<std::string, int> agree_once(MPI_Comm comm, const std::exception_ptr& error, Level level,
                                       double timeout) {
  const int ranks = size(comm);
  const std::array<int, 2> here{error ? rank(comm) : ranks, level};
  std::array<int, 2> minimum{};
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallreduce(here.data(), minimum.data(), 2, MPI_INT, MPI_MIN, comm, &request);
  if (!wait_idly(request, timeout)) leave_the_others(rank(comm), error);
  if (minimum[0] == ranks) return {"", minimum[1]};
  const std::string record = here[0] == minimum[0] ? to_record(describe(error)) : std::string();
  return {broadcast(record, minimum[0], comm), minimum[1]};
}

}  // namespace

void agree(MPI_Comm comm, const std::exception_ptr& error, double timeout) {
  const auto [record, level] = agree_once(comm, error, stage, error ? timeout : endless);
  if (!record.empty()) raise(from_record(record));
}

void agree_at_end(MPI_Comm comm, const std::exception_ptr& error, double timeout) {
  std::string first;
  for (;;) {
    const auto [record, level] = agree_once(comm, error, end, error ? timeout : endless);
    if (first.empty()) first = record;
    if (level == end) break;
  }
  if (!first.empty()) raise(from_record(first));
}

}  // namespace carillon::mpi
