#include "eval/studies/learning/detail/mpi_learning.hpp"

#include "mpi/comm.hpp"

namespace carillon::eval::studies {

networks::LearningRanks learning_ranks(MPI_Comm comm) {
  networks::LearningRanks ranks;
  ranks.rank = mpi::rank(comm);
  ranks.size = mpi::size(comm);
  if (ranks.size == 1) return ranks;
  ranks.sum = [comm](std::span<float> values) {
    MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_FLOAT, MPI_SUM,
                  comm);
  };
  ranks.share = [comm](const std::string& text) { return mpi::broadcast(text, 0, comm); };
  ranks.agree = [comm](const std::exception_ptr& error) { mpi::agree(comm, error); };
  return ranks;
}

}  // namespace carillon::eval::studies
