#include "solvers/libraries/one_thread.hpp"

// Of the run-time library that SuiteSparse runs on, whose header need not be this compiler's.
extern "C" {
void omp_set_max_active_levels(int levels);
int omp_get_max_active_levels();
}

namespace carillon::solvers::libraries {

OneThread::OneThread() : former_(omp_get_max_active_levels()) {
  omp_set_max_active_levels(0);
}

OneThread::~OneThread() {
  omp_set_max_active_levels(former_);
}

}  // namespace carillon::solvers::libraries
