#pragma once

#include <CGAL/AABB_tree.h>
#include <CGAL/version.h>

#if CGAL_VERSION_NR < 1060000000  // 6.0
#include <CGAL/AABB_segment_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_triangle_primitive.h>

#include <boost/variant.hpp>
#else
#include <CGAL/AABB_segment_primitive_3.h>
#include <CGAL/AABB_traits_3.h>
#include <CGAL/AABB_triangle_primitive_3.h>

#include <variant>
#endif

#include <vector>

namespace carillon::solvers::mesh::simplify {

template <class Kernel>
using CgalTriangles = std::vector<typename Kernel::Triangle_3>;
template <class Kernel>
using CgalSegments = std::vector<typename Kernel::Segment_3>;

/// Trees of boxes around triangles and segments, and the value of a variant that CGAL returns where
/// it has this type, else null. CGAL 6 has other names for the parts of a tree, and the standard
/// library's variants.
#if CGAL_VERSION_NR < 1060000000
template <class Kernel>
using CgalTriangleTree = CGAL::AABB_tree<CGAL::AABB_traits<
    Kernel, CGAL::AABB_triangle_primitive<Kernel, typename CgalTriangles<Kernel>::const_iterator>>>;
template <class Kernel>
using CgalSegmentTree = CGAL::AABB_tree<CGAL::AABB_traits<
    Kernel, CGAL::AABB_segment_primitive<Kernel, typename CgalSegments<Kernel>::const_iterator>>>;

template <class Value, class Variant>
const Value* held(const Variant& variant) {
  return boost::get<Value>(&variant);
}
#else
template <class Kernel>
using CgalTriangleTree = CGAL::AABB_tree<CGAL::AABB_traits_3<
    Kernel,
    CGAL::AABB_triangle_primitive_3<Kernel, typename CgalTriangles<Kernel>::const_iterator>>>;
template <class Kernel>
using CgalSegmentTree = CGAL::AABB_tree<CGAL::AABB_traits_3<
    Kernel, CGAL::AABB_segment_primitive_3<Kernel, typename CgalSegments<Kernel>::const_iterator>>>;

template <class Value, class Variant>
const Value* held(const Variant& variant) {
  return std::get_if<Value>(&variant);
}
#endif

}  // namespace carillon::solvers::mesh::simplify
