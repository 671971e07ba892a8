#pragma once

#include <CGAL/version.h>

#if CGAL_VERSION_NR < 1060000000  // 6.0
#include <boost/optional.hpp>
#else
#include <optional>
#endif

namespace carillon::solvers::mesh::simplify {

/// What CGAL takes and returns where there may be no value: Boost's before version 6.
#if CGAL_VERSION_NR < 1060000000
template <class Value>
using CgalOptional = boost::optional<Value>;
#else
template <class Value>
using CgalOptional = std::optional<Value>;
#endif

}  // namespace carillon::solvers::mesh::simplify
