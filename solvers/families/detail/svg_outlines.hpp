#pragma once

#include <string>
#include <vector>

#include "solvers/families/detail/svg_path.hpp"

namespace carillon::solvers::families {

/// An outline of a drawing, transformations applied, y down as in SVG.
struct SvgOutline {
  std::string name;  ///< for a person: "path \"cup\"", "second rect"
  std::string id;    ///< "" where it has none
  std::vector<PathCurve> curves;
};

struct SvgDrawing {
  std::vector<SvgOutline> outlines;
  double unit = 0;  ///< of its coordinates [m]; 0: the drawing does not say
};

/// What a drawing shows: path, rect, circle, ellipse, polygon and polyline, also by use, in groups
/// and nested drawings; their transformations, lengths with units (CSS: 96 px to the inch) and the
/// size on paper of width, height and viewBox. What is in defs, symbol, clipPath, mask, pattern and
/// marker is not shown, nor what has display: none. Text, pictures and styles say nothing of an
/// outline.
/// @throws InputError  no XML, no drawing, malformed values; names the element
/// SVG 1.1 (W3C 2011), sections 5, 7 to 9.
SvgDrawing read_svg(const std::string& text);

}  // namespace carillon::solvers::families
