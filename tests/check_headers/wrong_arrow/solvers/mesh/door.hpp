#pragma once

#include "solvers/eigen/door.hpp"
#include "solvers/mesh/detail/inner.hpp"
