#pragma once

#include <string>

namespace carillon::solvers::libraries {

/// What is wrong with the BLAS that this process was linked to at run time, for a person; empty
/// when nothing is. The reference BLAS is many times slower than a tuned one, and threads of its
/// own stand in the way of other ranks.
std::string blas_complaint();

/// Name and version of the BLAS in use, e.g. "OpenBLAS 0.3.21", without what it chose for the
/// machine.
std::string blas_version();

}  // namespace carillon::solvers::libraries
