#include "scene/live/request.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"

namespace carillon::scene::live {

namespace {

using core::Dimension;
using core::InputError;

/// The words of a line, taken one after the other.
class Words {
 public:
  explicit Words(std::string_view line) {
    line = line.substr(0, line.find('#'));
    constexpr std::string_view blank = " \t\r\n";
    for (std::size_t at = line.find_first_not_of(blank); at != std::string_view::npos;
         at = line.find_first_not_of(blank, at)) {
      const std::size_t end = std::min(line.find_first_of(blank, at), line.size());
      words_.emplace_back(line.substr(at, end - at));
      at = end;
    }
  }

  bool done() const { return next_ == words_.size(); }
  bool take(std::string_view word) {
    if (done() || words_[next_] != word) return false;
    ++next_;
    return true;
  }
  /// @param what  for messages
  std::string word(const char* what) {
    if (done()) throw InputError(fmt::format("{} is missing", what), usage);
    return words_[next_++];
  }
  double value(const char* what, Dimension dimension) {
    const std::string text = word(what);
    double value = 0;
    try {
      value = core::parse_quantity(text, dimension);
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", what, error.message()), error.hint());
    }
    if (!std::isfinite(value)) throw InputError(fmt::format("{} is not finite: {}", what, text));
    return value;
  }
  Vec3 vector(const char* what, Dimension dimension) {
    const double x = value(what, dimension), y = value(what, dimension);
    return {x, y, value(what, dimension)};
  }
  int number(const char* what) {
    const std::string text = word(what);
    if (text.empty() || text.size() > 6 ||
        text.find_first_not_of("0123456789") != std::string::npos) {
      throw InputError(fmt::format("{} is a number from 0, not \"{}\"", what, text));
    }
    return std::stoi(text);
  }

  static constexpr const char* usage =
      "lines are TIME strike OBJECT [position X Y Z] [direction X Y Z] [impulse J] [contact T], "
      "TIME support OBJECT NUMBER on|off|[stiffness K] [damping C], TIME damp OBJECT AMOUNT, and "
      "TIME stop";

 private:
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

void parse_strike(Words& words, Request& request) {
  request.kind = Request::Kind::strike;
  request.object = words.word("the object");
  while (!words.done()) {
    if (words.take("position")) {
      request.position = words.vector("position", Dimension::length);
    } else if (words.take("direction")) {
      request.direction = words.vector("direction", Dimension::none);
    } else if (words.take("impulse")) {
      request.impulse = words.value("impulse", Dimension::impulse);
    } else if (words.take("contact")) {
      request.contact = words.value("contact", Dimension::time);
    } else {
      throw InputError(fmt::format("a strike has no \"{}\"", words.word("")), Words::usage);
    }
  }
}

void parse_support(Words& words, Request& request) {
  request.kind = Request::Kind::support;
  request.object = words.word("the object");
  request.support = words.number("the support");
  if (words.done()) throw InputError("on, off, stiffness or damping is missing", Words::usage);
  while (!words.done()) {
    if (words.take("on")) {
      request.on = true;
    } else if (words.take("off")) {
      request.on = false;
    } else if (words.take("stiffness")) {
      request.stiffness = words.value("stiffness", Dimension::stiffness);
    } else if (words.take("damping")) {
      request.damping = words.value("damping", Dimension::resistance);
    } else {
      throw InputError(fmt::format("a support has no \"{}\"", words.word("")), Words::usage);
    }
  }
}

}  // namespace

std::optional<Request> parse_request(std::string_view line) {
  Words words(line);
  if (words.done()) return std::nullopt;
  Request request;
  if (!words.take("-")) {
    request.time = words.value("the time", Dimension::time);
    if (!(*request.time >= 0)) throw InputError("the time is negative");
  }
  if (words.take("strike")) {
    parse_strike(words, request);
  } else if (words.take("support")) {
    parse_support(words, request);
  } else if (words.take("damp")) {
    request.kind = Request::Kind::damp;
    request.object = words.word("the object");
    request.amount = words.value("the amount", Dimension::none);
  } else if (words.take("stop")) {
    request.kind = Request::Kind::stop;
  } else {
    const std::string word = words.word("what happens");
    throw InputError(fmt::format("there is no event \"{}\"", word), Words::usage);
  }
  if (!words.done()) {
    throw InputError(fmt::format("\"{}\" is too much", words.word("")), Words::usage);
  }
  return request;
}

}  // namespace carillon::scene::live
