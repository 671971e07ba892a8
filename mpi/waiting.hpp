#pragma once

namespace carillon::mpi {

/// Processor time [s] that the calling thread has spent inside calls of MPI that wait for other
/// ranks: of this program and of the libraries it links, PETSc's and MUMPS' among them. MPI spins
/// while it waits, which looks like work to the system's clocks and is none.
double seconds_in_mpi();

}  // namespace carillon::mpi
