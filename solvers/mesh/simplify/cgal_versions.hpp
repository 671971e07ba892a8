#pragma once

#include <CGAL/version.h>

#if CGAL_VERSION_NR < 1060000000  // 6.0
#include <CGAL/AABB_traits.h>

#include <boost/optional.hpp>
#include <boost/variant.hpp>
#else
#include <CGAL/AABB_traits_3.h>

#include <optional>
#include <variant>
#endif

namespace carillon::solvers::mesh::simplify {

/// What CGAL 6 names otherwise than CGAL 5, or takes from the standard library instead of Boost.
#if CGAL_VERSION_NR < 1060000000  // 6.0
template <class Value>
using CgalOptional = boost::optional<Value>;

template <class Kernel, class Primitive>
using CgalTreeTraits = CGAL::AABB_traits<Kernel, Primitive>;

/// The value of a variant where it has this type, else null.
template <class Value, class Variant>
const Value* held(const Variant& variant) {
  return boost::get<Value>(&variant);
}
#else
template <class Value>
using CgalOptional = std::optional<Value>;

template <class Kernel, class Primitive>
using CgalTreeTraits = CGAL::AABB_traits_3<Kernel, Primitive>;

template <class Value, class Variant>
const Value* held(const Variant& variant) {
  return std::get_if<Value>(&variant);
}
#endif

}  // namespace carillon::solvers::mesh::simplify
