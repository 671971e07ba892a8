#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/error.hpp"
#include "core/files.hpp"
#include "solvers/families/detail/svg_path.hpp"
#include "solvers/families/families.hpp"
#include "solvers/families/outline.hpp"

namespace carillon::solvers::families {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/// One tag of an XML file: `<name key="value" ...>`.
struct Tag {
  std::string name;  ///< with a leading / for an end tag
  std::map<std::string, std::string> attributes;
  bool empty = false;  ///< ends in />
};

/// Walks through the tags of an XML file; comments, declarations and text are skipped. Enough for
/// drawings, where no entity can stand inside path data.
class TagReader {
 public:
  explicit TagReader(const std::string& text) : text_(text) {}

  bool next(Tag& tag) {
    for (;;) {
      at_ = text_.find('<', at_);
      if (at_ == std::string::npos) return false;
      if (skip("<!--", "-->") || skip("<![CDATA[", "]]>") || skip("<?", "?>") || skip("<!", ">"))
        continue;
      ++at_;
      tag = {};
      while (at_ < text_.size() && !is_space(text_[at_]) && text_[at_] != '>' &&
             (text_[at_] != '/' || tag.name.empty()))
        tag.name += text_[at_++];
      while (read_attribute(tag)) {
      }
      return true;
    }
  }

 private:
  bool skip(const std::string& opening, const std::string& closing) {
    if (text_.compare(at_, opening.size(), opening) != 0) return false;
    const auto end = text_.find(closing, at_ + opening.size());
    at_ = end == std::string::npos ? text_.size() : end + closing.size();
    return true;
  }

  /// False at the end of the tag.
  bool read_attribute(Tag& tag) {
    while (at_ < text_.size() && (is_space(text_[at_]) || text_[at_] == '/')) {
      tag.empty = text_[at_] == '/';
      ++at_;
    }
    if (at_ >= text_.size()) return false;
    if (text_[at_] == '>') {
      ++at_;
      return false;
    }
    std::string key;
    while (at_ < text_.size() && text_[at_] != '=' && text_[at_] != '>' && !is_space(text_[at_]))
      key += text_[at_++];
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
    if (at_ >= text_.size() || text_[at_] != '=') return at_ < text_.size();
    ++at_;
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
    if (at_ >= text_.size() || (text_[at_] != '"' && text_[at_] != '\'')) return false;
    const char quote = text_[at_++];
    const auto end = text_.find(quote, at_);
    if (end == std::string::npos) {
      at_ = text_.size();
      return false;
    }
    tag.attributes[key] = text_.substr(at_, end - at_);
    at_ = end + 1;
    return true;
  }

  const std::string& text_;
  std::size_t at_ = 0;
};

/// Path data of the first path; refuses a path that a transformation moves.
std::string first_path(const std::string& text, const std::string& file) {
  TagReader reader(text);
  Tag tag;
  std::vector<bool> moved;  // one for each open group
  while (reader.next(tag)) {
    const bool transformed = tag.attributes.count("transform") > 0;
    if (tag.name == "path" && tag.attributes.count("d") > 0) {
      if (transformed || std::find(moved.begin(), moved.end(), true) != moved.end())
        throw core::InputError(file + ": the path is moved by a transform attribute",
                               "apply the transformation in the drawing program first");
      return tag.attributes["d"];
    }
    if (tag.name == "g" && !tag.empty) moved.push_back(transformed);
    if (tag.name == "/g" && !moved.empty()) moved.pop_back();
  }
  throw core::InputError(file + ": no path in this SVG file",
                         "draw the half section as one path (outlines of other kinds can be "
                         "converted to a path)");
}

std::array<double, 2> point_of(const PathCurve& curve, double t) {
  const double s = 1 - t;
  const std::array<double, 4> b{s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
  std::array<double, 2> p{0, 0};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 2; ++k) p[k] += b[i] * curve.points[i][k];
  return p;
}

/// Points of an outline, each of which is held against all others for crossings.
constexpr double max_points = 1e4;

/// Equal steps in t whose chords stay within `tolerance`: |B''| / (8 n^2) bounds their distance.
/// Without end for a curve that reaches without end to the side.
double steps_of(const PathCurve& curve, double tolerance) {
  if (curve.straight) return 1;
  double second = 0;
  for (std::size_t i = 0; i < 2; ++i)
    second = std::max(
        second,
        6 * std::hypot(curve.points[i][0] - 2 * curve.points[i + 1][0] + curve.points[i + 2][0],
                       curve.points[i][1] - 2 * curve.points[i + 1][1] + curve.points[i + 2][1]));
  return std::max(1.0, std::ceil(std::sqrt(second / (8 * tolerance))));
}

}  // namespace

std::vector<std::array<double, 2>> profile_from_svg(const std::string& path, double height) {
  if (!(height > 0) || !std::isfinite(height))
    throw core::InputError(fmt::format("the height of a profile must be positive, not {}", height));
  std::vector<PathCurve> curves;
  try {
    curves = parse_svg_path(first_path(core::read_file(path), path));
  } catch (const core::InputError& error) {
    if (error.message().rfind(path, 0) == 0) throw;
    throw core::InputError(path + ": " + error.message(), error.hint());
  }
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& curve : curves)
    for (int k = 0; k <= 64; ++k) {
      const double y = point_of(curve, k / 64.0)[1];
      low = std::min(low, y);
      high = std::max(high, y);
    }
  if (!(high > low)) throw core::InputError(path + ": the path has no height");

  ProfilePolygon polygon;
  for (const auto& curve : curves) {
    const double steps = steps_of(curve, 1e-4 * (high - low));
    if (!(static_cast<double>(polygon.size()) + steps <= max_points))
      throw core::InputError(
          path +
              ": an outline that is true to a ten thousandth of its height has more than 10000 "
              "points",
          "draw the half section alone, as one outline with few curves, none far wider than it is "
          "high");
    for (int k = 0; k < static_cast<int>(steps); ++k) {
      const auto p = point_of(curve, k / steps);
      polygon.push_back({p[0], -p[1]});
    }
  }
  double bottom = std::numeric_limits<double>::infinity(), top = -bottom;
  for (const auto& p : polygon) {
    bottom = std::min(bottom, p[1]);
    top = std::max(top, p[1]);
  }
  const double scale = height / (top - bottom);
  for (auto& p : polygon) p = {p[0] * scale, (p[1] - bottom) * scale};
  return checked_profile(polygon, path);
}

}  // namespace carillon::solvers::families
