#include "mpi/comm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <cstdint>
#include <numeric>

#include "core/error.hpp"
#include "mpi/failure.hpp"
#include "mpi/patience.hpp"

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

std::string broadcast(const std::string& text, int root, MPI_Comm comm) {
  std::uint64_t length = text.size();
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(&length, 1, MPI_UINT64_T, root, comm, &request);
  wait_patiently(request);
  std::string result = rank(comm) == root ? text : std::string(length, '\0');
  // Counts are int in MPI 3: a longer text goes in pieces.
  for (std::uint64_t sent = 0; sent < length;) {
    const auto piece = static_cast<int>(std::min<std::uint64_t>(length - sent, INT_MAX / 2));
    MPI_Ibcast(result.data() + sent, piece, MPI_CHAR, root, comm, &request);
    wait_patiently(request);
    sent += static_cast<std::uint64_t>(piece);
  }
  return result;
}

std::vector<std::string> all_gather(const std::string& text, MPI_Comm comm) {
  const auto ranks = static_cast<std::size_t>(size(comm));
  const std::uint64_t length = text.size();
  std::vector<std::uint64_t> lengths(ranks);
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallgather(&length, 1, MPI_UINT64_T, lengths.data(), 1, MPI_UINT64_T, comm, &request);
  wait_patiently(request);
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
  wait_patiently(request);
  std::vector<std::string> texts;
  texts.reserve(ranks);
  std::size_t begin = 0;
  for (const std::uint64_t bytes : lengths) {
    texts.push_back(joined.substr(begin, bytes));
    begin += bytes;
  }
  return texts;
}

void agree(MPI_Comm comm, const std::exception_ptr& error) {
  const int ranks = size(comm);
  const int here = error ? rank(comm) : ranks;
  int lowest = ranks;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallreduce(&here, &lowest, 1, MPI_INT, MPI_MIN, comm, &request);
  wait_patiently(request);
  if (lowest == ranks) return;
  const std::string record = here == lowest ? to_record(describe(error)) : std::string();
  raise(from_record(broadcast(record, lowest, comm)));
}

}  // namespace carillon::mpi
