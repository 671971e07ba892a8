#pragma once

#include "solvers/mesh/detail/inner.hpp"
#include "solvers/mesh/door.hpp"
