#pragma once

#include "core/failure.hpp"

namespace carillon::mpi {

using core::describe;
using core::Failure;
using core::from_record;
using core::raise;
using core::TaskError;
using core::to_record;

}  // namespace carillon::mpi
