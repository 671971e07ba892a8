#include "solvers/families/detail/svg_outlines.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <pugixml.hpp>
#include <string_view>

#include "core/error.hpp"
#include "core/vectors.hpp"

namespace carillon::solvers::families {
namespace {

using Transform = Eigen::Affine2d;

constexpr double pixel = 0.0254 / 96;  ///< [m]
constexpr int max_depth = 64;          ///< of nested elements and uses

/// Units of lengths in pixels (CSS 2.1, section 4.3.2).
constexpr std::array<std::pair<std::string_view, double>, 8> units = {{{"", 1},
                                                                       {"px", 1},
                                                                       {"pt", 96.0 / 72},
                                                                       {"pc", 16},
                                                                       {"mm", 96 / 25.4},
                                                                       {"cm", 960 / 25.4},
                                                                       {"Q", 24 / 25.4},
                                                                       {"in", 96}}};

/// The name without the prefix of its namespace.
std::string_view local_name(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const auto colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

/// Numbers between blanks and commas, as far as they go.
std::vector<double> numbers_in(std::string_view text) {
  std::vector<double> found;
  for (;;) {
    const auto begin = text.find_first_not_of(" ,\t\r\n");
    if (begin == std::string_view::npos) return found;
    text.remove_prefix(begin);
    if (text.front() == '+') text.remove_prefix(1);
    double value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || !std::isfinite(value))
      throw core::InputError(fmt::format("\"{}\" is no number", text.substr(0, 12)));
    found.push_back(value);
    text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
  }
}

/// A length in pixels.
/// @throws InputError  no number, or a unit that depends on what is around
double length_of(std::string_view text) {
  const auto end = text.find_last_not_of(" \t\r\n");
  text = text.substr(0, end == std::string_view::npos ? 0 : end + 1);
  const auto begin = text.find_first_not_of(" \t\r\n+");
  text.remove_prefix(std::min(begin, text.size()));
  double value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit = text.substr(static_cast<std::size_t>(stop - text.data()));
  const auto known = std::find_if(units.begin(), units.end(),
                                  [unit](const auto& one) { return one.first == unit; });
  if (error != std::errc() || !std::isfinite(value) || known == units.end())
    throw core::InputError(fmt::format("\"{}\" is no length in px, pt, pc, mm, cm or in", text));
  return value * known->second;
}

double attribute(const pugi::xml_node& node, const char* name, double otherwise = 0) {
  const pugi::xml_attribute given = node.attribute(name);
  return given.empty() ? otherwise : length_of(given.value());
}

Transform one_transform(std::string_view name, const std::vector<double>& v) {
  const auto has = [&v](std::initializer_list<std::size_t> counts) {
    return std::find(counts.begin(), counts.end(), v.size()) != counts.end();
  };
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180; };
  Transform out = Transform::Identity();
  if (name == "matrix" && has({6})) {
    out.matrix().topRows<2>() << v[0], v[2], v[4], v[1], v[3], v[5];
  } else if (name == "translate" && has({1, 2})) {
    out.translation() = Vec2(v[0], v.size() > 1 ? v[1] : 0);
  } else if (name == "scale" && has({1, 2})) {
    out.linear() = Vec2(v[0], v.back()).asDiagonal();
  } else if (name == "rotate" && has({1, 3})) {
    const Vec2 about = v.size() == 3 ? Vec2(v[1], v[2]) : Vec2(0, 0);
    out = Eigen::Translation2d(about) * Eigen::Rotation2Dd(radians(v[0])) *
          Eigen::Translation2d(-about);
  } else if (name == "skewX" && has({1})) {
    out.linear()(0, 1) = std::tan(radians(v[0]));
  } else if (name == "skewY" && has({1})) {
    out.linear()(1, 0) = std::tan(radians(v[0]));
  } else {
    throw core::InputError(fmt::format("{} of {} numbers is no transformation", name, v.size()));
  }
  return out;
}

/// `translate(3 4) rotate(90)`: the last is applied first.
Transform transform_of(std::string_view text) {
  Transform out = Transform::Identity();
  for (;;) {
    const auto begin = text.find_first_not_of(" ,\t\r\n");
    if (begin == std::string_view::npos || text.substr(begin) == "none") return out;
    const auto open = text.find('(', begin), close = text.find(')', begin);
    if (open == std::string_view::npos || close == std::string_view::npos || close < open)
      throw core::InputError(fmt::format("\"{}\" is no transformation", text.substr(begin, 24)));
    std::string_view name = text.substr(begin, open - begin);
    name = name.substr(0, name.find_last_not_of(" \t\r\n") + 1);
    out = out * one_transform(name, numbers_in(text.substr(open + 1, close - open - 1)));
    text.remove_prefix(close + 1);
  }
}

std::string ellipse_path(double x, double y, double a, double b) {
  if (!(a > 0) || !(b > 0)) return "";
  return fmt::format("M{} {}A{} {} 0 0 1 {} {}A{} {} 0 0 1 {} {}Z", x - a, y, a, b, x + a, y, a, b,
                     x - a, y);
}

std::string rect_path(const pugi::xml_node& node) {
  const double x = attribute(node, "x"), y = attribute(node, "y");
  const double w = attribute(node, "width"), h = attribute(node, "height");
  if (!(w > 0) || !(h > 0)) return "";
  const bool has_rx = !node.attribute("rx").empty(), has_ry = !node.attribute("ry").empty();
  double rx = attribute(node, has_rx ? "rx" : "ry"), ry = attribute(node, has_ry ? "ry" : "rx");
  rx = std::clamp(rx, 0.0, w / 2);
  ry = std::clamp(ry, 0.0, h / 2);
  if (rx == 0 || ry == 0) return fmt::format("M{} {}h{}v{}h{}Z", x, y, w, h, -w);
  return fmt::format(
      "M{} {}h{}a{} {} 0 0 1 {} {}v{}a{} {} 0 0 1 {} {}h{}a{} {} 0 0 1 {} {}v{}a{} "
      "{} 0 0 1 {} {}Z",
      x + rx, y, w - 2 * rx, rx, ry, rx, ry, h - 2 * ry, rx, ry, -rx, ry, 2 * rx - w, rx, ry, -rx,
      -ry, 2 * ry - h, rx, ry, rx, -ry);
}

/// The outline of an element as path data; "" for one that has none.
std::string path_data(const pugi::xml_node& node) {
  const std::string_view name = local_name(node);
  if (name == "path") return node.attribute("d").value();
  if (name == "rect") return rect_path(node);
  if (name == "circle") {
    const double r = attribute(node, "r");
    return ellipse_path(attribute(node, "cx"), attribute(node, "cy"), r, r);
  }
  if (name == "ellipse")
    return ellipse_path(attribute(node, "cx"), attribute(node, "cy"), attribute(node, "rx"),
                        attribute(node, "ry"));
  if (name == "polygon" || name == "polyline") {
    const std::string points = node.attribute("points").value();
    return points.empty() ? "" : "M" + points;
  }
  return "";
}

bool is_hidden(const pugi::xml_node& node) {
  std::string style = node.attribute("style").value();
  style.erase(std::remove_if(style.begin(), style.end(), [](char c) { return c == ' '; }),
              style.end());
  return std::string_view(node.attribute("display").value()) == "none" ||
         style.find("display:none") != std::string::npos;
}

class Reader {
 public:
  explicit Reader(const pugi::xml_node& root) : root_(root) {}

  SvgDrawing read() {
    drawing_.unit = unit_of_root();
    children(root_, Transform::Identity(), 0);
    return std::move(drawing_);
  }

 private:
  /// Metres to a unit of coordinates, by the size on paper.
  double unit_of_root() const {
    const std::string_view width = root_.attribute("width").value();
    const bool on_paper = width.find_first_of("mcipQ") != std::string_view::npos &&
                          width.find("px") == std::string_view::npos;
    if (!on_paper) return 0;
    const auto box = numbers_in(root_.attribute("viewBox").value());
    if (box.size() != 4) return pixel;
    return box[2] > 0 ? pixel * length_of(width) / box[2] : 0;
  }

  void children(const pugi::xml_node& node, const Transform& transform, int depth) {
    if (depth > max_depth)
      throw core::InputError(fmt::format("elements are nested more than {} deep", max_depth));
    for (const pugi::xml_node& child : node.children()) element(child, transform, depth + 1);
  }

  void element(const pugi::xml_node& node, const Transform& outside, int depth) {
    if (node.type() != pugi::node_element || is_hidden(node)) return;
    const std::string_view kind = local_name(node);
    const std::string name = name_of(node);
    try {
      const Transform transform = outside * transform_of(node.attribute("transform").value());
      if (kind == "g" || kind == "a" || kind == "switch") {
        children(node, transform, depth);
      } else if (kind == "svg" || kind == "use") {
        const Vec2 place(attribute(node, "x"), attribute(node, "y"));
        const Transform moved = transform * Eigen::Translation2d(place);
        kind == "svg" ? children(node, moved, depth) : use(node, moved, depth);
      } else if (const std::string data = path_data(node); !data.empty()) {
        add(node, name, parse_svg_path(data), transform);
      }
    } catch (const core::InputError& error) {
      // Said once, of the innermost element.
      if (error.message().rfind(told_, 0) == 0) throw;
      throw core::InputError(fmt::format("{}{}: {}", told_, name, error.message()), error.hint());
    }
  }

  void use(const pugi::xml_node& node, const Transform& transform, int depth) {
    std::string_view link = node.attribute("href").value();
    if (link.empty()) link = node.attribute("xlink:href").value();
    if (link.size() < 2 || link.front() != '#') return;
    const std::string id(link.substr(1));
    const pugi::xml_node target = root_.find_node(
        [&id](const pugi::xml_node& one) { return id == one.attribute("id").value(); });
    if (depth > max_depth)
      throw core::InputError(fmt::format("uses are nested more than {} deep", max_depth));
    if (local_name(target) == "symbol")
      children(target, transform, depth);
    else
      element(target, transform, depth + 1);
  }

  std::string name_of(const pugi::xml_node& node) {
    const std::string kind(local_name(node));
    const std::string id = node.attribute("id").value();
    const int number = ++seen_[kind];
    return id.empty() ? fmt::format("{} number {}", kind, number)
                      : fmt::format("{} \"{}\"", kind, id);
  }

  void add(const pugi::xml_node& node, const std::string& name, std::vector<PathCurve> curves,
           const Transform& transform) {
    for (PathCurve& curve : curves)
      for (auto& point : curve.points) {
        const Vec2 moved = transform * Vec2(point[0], point[1]);
        point = {moved.x(), moved.y()};
      }
    drawing_.outlines.push_back({name, node.attribute("id").value(), std::move(curves)});
  }

  static constexpr std::string_view told_ = "the drawing's ";
  pugi::xml_node root_;
  SvgDrawing drawing_;
  std::map<std::string, int> seen_;
};

}  // namespace

SvgDrawing read_svg(const std::string& text) {
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
  if (!result)
    throw core::InputError(
        fmt::format("no XML: {} at byte {}", result.description(), result.offset));
  for (const pugi::xml_node& node : document.children())
    if (local_name(node) == "svg") return Reader(node).read();
  throw core::InputError("there is no drawing (element svg) in it");
}

}  // namespace carillon::solvers::families
