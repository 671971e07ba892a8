// MPI's profiling interface: the library's functions have a second name, PMPI_..., so that a
// program may put its own in place of the first. Those below add up the processor time of the calls
// that wait. Fortran's names are needed for MUMPS.
#include "mpi/waiting.hpp"

#include <dlfcn.h>
#include <mpi.h>

#include "core/trace.hpp"

namespace {

thread_local double total = 0;

/// Adds the processor time of its life.
class Waiting {
 public:
  Waiting() : start_(carillon::core::thread_cpu_seconds()) {}
  ~Waiting() { total += carillon::core::thread_cpu_seconds() - start_; }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;

 private:
  double start_;
};

}  // namespace

namespace carillon::mpi {

double seconds_in_mpi() {
  return total;
}

}  // namespace carillon::mpi

#define CARILLON_TIMED(name, parameters, arguments) \
  int MPI_##name parameters {                       \
    const Waiting waiting;                          \
    return PMPI_##name arguments;                   \
  }
// Found at run time: programs without MUMPS do not link MPI's Fortran library, and never call
// these.
#define CARILLON_TIMED_FORTRAN(name, parameters, arguments)                                   \
  void mpi_##name##_ parameters {                                                             \
    using Function = void(*) parameters;                                                      \
    static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "pmpi_" #name "_")); \
    const Waiting waiting;                                                                    \
    real arguments;                                                                           \
  }

extern "C" {

CARILLON_TIMED(Barrier, (MPI_Comm c), (c))
CARILLON_TIMED(Bcast, (void* b, int n, MPI_Datatype t, int r, MPI_Comm c), (b, n, t, r, c))
CARILLON_TIMED(Reduce, (const void* s, void* d, int n, MPI_Datatype t, MPI_Op o, int r, MPI_Comm c),
               (s, d, n, t, o, r, c))
CARILLON_TIMED(Allreduce, (const void* s, void* d, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c),
               (s, d, n, t, o, c))
CARILLON_TIMED(Scan, (const void* s, void* d, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c),
               (s, d, n, t, o, c))
CARILLON_TIMED(Gather,
               (const void* s, int n, MPI_Datatype t, void* d, int m, MPI_Datatype u, int r,
                MPI_Comm c),
               (s, n, t, d, m, u, r, c))
CARILLON_TIMED(Gatherv,
               (const void* s, int n, MPI_Datatype t, void* d, const int* m, const int* at,
                MPI_Datatype u, int r, MPI_Comm c),
               (s, n, t, d, m, at, u, r, c))
CARILLON_TIMED(Allgather,
               (const void* s, int n, MPI_Datatype t, void* d, int m, MPI_Datatype u, MPI_Comm c),
               (s, n, t, d, m, u, c))
CARILLON_TIMED(Allgatherv,
               (const void* s, int n, MPI_Datatype t, void* d, const int* m, const int* at,
                MPI_Datatype u, MPI_Comm c),
               (s, n, t, d, m, at, u, c))
CARILLON_TIMED(Alltoall,
               (const void* s, int n, MPI_Datatype t, void* d, int m, MPI_Datatype u, MPI_Comm c),
               (s, n, t, d, m, u, c))
CARILLON_TIMED(Alltoallv,
               (const void* s, const int* n, const int* from, MPI_Datatype t, void* d, const int* m,
                const int* at, MPI_Datatype u, MPI_Comm c),
               (s, n, from, t, d, m, at, u, c))
CARILLON_TIMED(Send, (const void* b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c),
               (b, n, t, to, tag, c))
CARILLON_TIMED(Recv, (void* b, int n, MPI_Datatype t, int from, int tag, MPI_Comm c, MPI_Status* s),
               (b, n, t, from, tag, c, s))
CARILLON_TIMED(Probe, (int from, int tag, MPI_Comm c, MPI_Status* s), (from, tag, c, s))
CARILLON_TIMED(Wait, (MPI_Request * r, MPI_Status* s), (r, s))
CARILLON_TIMED(Waitall, (int n, MPI_Request r[], MPI_Status s[]), (n, r, s))
CARILLON_TIMED(Waitany, (int n, MPI_Request r[], int* i, MPI_Status* s), (n, r, i, s))

CARILLON_TIMED_FORTRAN(barrier, (int* c, int* e), (c, e))
CARILLON_TIMED_FORTRAN(bcast, (void* b, int* n, int* t, int* r, int* c, int* e), (b, n, t, r, c, e))
CARILLON_TIMED_FORTRAN(reduce, (void* s, void* d, int* n, int* t, int* o, int* r, int* c, int* e),
                       (s, d, n, t, o, r, c, e))
CARILLON_TIMED_FORTRAN(allreduce, (void* s, void* d, int* n, int* t, int* o, int* c, int* e),
                       (s, d, n, t, o, c, e))
CARILLON_TIMED_FORTRAN(recv, (void* b, int* n, int* t, int* f, int* tag, int* c, int* s, int* e),
                       (b, n, t, f, tag, c, s, e))
CARILLON_TIMED_FORTRAN(probe, (int* f, int* tag, int* c, int* s, int* e), (f, tag, c, s, e))
CARILLON_TIMED_FORTRAN(iprobe, (int* f, int* tag, int* c, int* flag, int* s, int* e),
                       (f, tag, c, flag, s, e))
CARILLON_TIMED_FORTRAN(wait, (int* r, int* s, int* e), (r, s, e))
CARILLON_TIMED_FORTRAN(test, (int* r, int* flag, int* s, int* e), (r, flag, s, e))
CARILLON_TIMED_FORTRAN(waitall, (int* n, int* r, int* s, int* e), (n, r, s, e))

}  // extern "C"
