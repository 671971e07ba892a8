#include "solvers/families/detail/svg_path.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/vectors.hpp"

namespace carillon::solvers::families {
namespace {

class PathParser {
 public:
  explicit PathParser(const std::string& data) : data_(data) {}

  std::vector<PathCurve> parse() {
    skip();
    char command = 0;
    while (at_ < data_.size()) {
      if (std::isalpha(static_cast<unsigned char>(data_[at_]))) {
        command = data_[at_++];
      } else if (command == 0 || command == 'Z' || command == 'z') {
        fail("a command letter");
      }
      if (!started_ && command != 'M' && command != 'm') fail("M, which begins every path");
      run(command);
      // Coordinates after the first pair of a move are lines.
      if (command == 'M') command = 'L';
      if (command == 'm') command = 'l';
      skip();
    }
    if (!started_) fail("a path");
    close();
    return std::move(curves_);
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const {
    throw core::InputError(
        fmt::format("SVG path data, character {}: expected {}{}", at_ + 1, expected,
                    at_ < data_.size() ? fmt::format(", found \"{}\"", data_.substr(at_, 12))
                                       : std::string(", but the data end")));
  }

  void skip() {
    while (at_ < data_.size() &&
           (data_[at_] == ',' || std::isspace(static_cast<unsigned char>(data_[at_]))))
      ++at_;
  }

  double number() {
    skip();
    const char* begin = data_.data() + at_;
    const char* end = data_.data() + data_.size();
    if (begin != end && *begin == '+') ++begin;
    double value = 0;
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error != std::errc() || !std::isfinite(value)) fail("a number");
    at_ = static_cast<std::size_t>(stop - data_.data());
    return value;
  }

  /// Flags of an arc may stand without anything between them.
  bool flag() {
    skip();
    if (at_ >= data_.size() || (data_[at_] != '0' && data_[at_] != '1')) fail("a flag, 0 or 1");
    return data_[at_++] == '1';
  }

  Vec2 pair(bool relative) {
    const double x = number(), y = number();
    return relative ? Vec2(here_ + Vec2(x, y)) : Vec2(x, y);
  }

  void line(const Vec2& to) {
    curves_.push_back(
        {{{{here_.x(), here_.y()}, {here_.x(), here_.y()}, {to.x(), to.y()}, {to.x(), to.y()}}},
         true});
    here_ = to;
  }
  void cubic(const Vec2& a, const Vec2& b, const Vec2& to) {
    curves_.push_back(
        {{{{here_.x(), here_.y()}, {a.x(), a.y()}, {b.x(), b.y()}, {to.x(), to.y()}}}, false});
    here_ = to;
  }
  void quadratic(const Vec2& control, const Vec2& to) {
    cubic(here_ + 2.0 / 3 * (control - here_), to + 2.0 / 3 * (control - to), to);
  }

  void close() {
    if ((here_ - start_).norm() > 0) line(start_);
  }

  void run(char command) {
    const bool relative = std::islower(static_cast<unsigned char>(command)) != 0;
    const char kind = static_cast<char>(std::toupper(static_cast<unsigned char>(command)));
    if (closed_ && kind != 'Z') fail("the end: one outline is a profile");
    Vec2 control = here_;  // what S and T would reflect
    switch (kind) {
      case 'M':
        if (started_) fail("the end: one outline is a profile");
        started_ = true;
        here_ = start_ = pair(relative);
        control = here_;
        break;
      case 'L':
        line(pair(relative));
        break;
      case 'H': {
        const double x = number();
        line({relative ? here_.x() + x : x, here_.y()});
        break;
      }
      case 'V': {
        const double y = number();
        line({here_.x(), relative ? here_.y() + y : y});
        break;
      }
      case 'C':
      case 'S': {
        const bool after_cubic = before_ == 'C' || before_ == 'S';
        const Vec2 reflected = after_cubic ? Vec2(2 * here_ - control_) : here_;
        const Vec2 first = kind == 'C' ? pair(relative) : reflected;
        control = pair(relative);
        cubic(first, control, pair(relative));
        break;
      }
      case 'Q':
      case 'T': {
        const bool after_quadratic = before_ == 'Q' || before_ == 'T';
        const Vec2 reflected = after_quadratic ? Vec2(2 * here_ - control_) : here_;
        control = kind == 'Q' ? pair(relative) : reflected;
        quadratic(control, pair(relative));
        break;
      }
      case 'A': {
        const double rx = number(), ry = number(), rotation = number();
        const bool large = flag(), sweep = flag();
        arc(std::abs(rx), std::abs(ry), rotation * std::numbers::pi / 180, large, sweep,
            pair(relative));
        break;
      }
      case 'Z':
        close();
        closed_ = true;
        break;
      default:
        --at_;
        fail("one of M L H V C S Q T A Z");
    }
    before_ = kind;
    control_ = control;
  }

  /// Arc from end points to centre (SVG 1.1, appendix F.6), then cubics.
  void arc(double rx, double ry, double rotation, bool large, bool sweep, const Vec2& to) {
    if ((to - here_).norm() == 0) return;
    if (rx == 0 || ry == 0) return line(to);
    const Eigen::Rotation2Dd turn(rotation);
    const Vec2 half = turn.inverse() * Vec2(0.5 * (here_ - to));
    const double excess = std::sqrt(std::pow(half.x() / rx, 2) + std::pow(half.y() / ry, 2));
    if (excess > 1) {
      rx *= excess;
      ry *= excess;
    }
    const double a = std::pow(rx * half.y(), 2) + std::pow(ry * half.x(), 2);
    const double factor =
        (large != sweep ? 1 : -1) * std::sqrt(std::max(0.0, (rx * rx * ry * ry - a) / a));
    const Vec2 middle(factor * rx * half.y() / ry, -factor * ry * half.x() / rx);
    const Vec2 centre = turn * middle + 0.5 * (here_ + to);
    if (!(a > 0) || !std::isfinite(rx * rx * ry * ry) || !centre.allFinite())
      fail("an arc whose radii and ends can be squared");
    const auto angle_of = [&](const Vec2& p) {
      return std::atan2((p.y() - middle.y()) / ry, (p.x() - middle.x()) / rx);
    };
    const double from = angle_of(half);
    double swept = angle_of(-half) - from;
    if (sweep && swept < 0) swept += 2 * std::numbers::pi;
    if (!sweep && swept > 0) swept -= 2 * std::numbers::pi;
    const int parts = std::max(1, static_cast<int>(std::ceil(std::abs(swept) / 0.7854)));
    const double step = swept / parts, handle = 4.0 / 3 * std::tan(step / 4);
    const auto on = [&](double angle) -> Vec2 {
      return centre + turn * Vec2(rx * std::cos(angle), ry * std::sin(angle));
    };
    const auto slope = [&](double angle) -> Vec2 {
      return turn * Vec2(-rx * std::sin(angle), ry * std::cos(angle));
    };
    for (int k = 0; k < parts; ++k) {
      const double begin = from + k * step, end = begin + step;
      const Vec2 last = k + 1 == parts ? to : on(end);
      cubic(here_ + handle * slope(begin), last - handle * slope(end), last);
    }
  }

  const std::string& data_;
  std::size_t at_ = 0;
  std::vector<PathCurve> curves_;
  Vec2 here_{0, 0}, start_{0, 0}, control_{0, 0};
  char before_ = 0;
  bool started_ = false, closed_ = false;
};

}  // namespace

std::vector<PathCurve> parse_svg_path(const std::string& data) {
  return PathParser(data).parse();
}

}  // namespace carillon::solvers::families
