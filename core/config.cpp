#include "core/config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <utility>
#include <variant>

#include "core/detail/config_impl.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/what_is.hpp"

namespace carillon::core {

using Kind = ConfigTree::Kind;

ConfigNode::ConfigNode(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

ConfigNode ConfigNode::parse(const std::string& text, const std::string& file_name,
                             const std::vector<std::string>& overrides) {
  auto document = std::make_shared<Impl::Document>();
  document->file_name = file_name;
  document->root = parse_config_tree(text, file_name);
  for (const std::string& assignment : overrides) apply_override(document->root, assignment);
  auto impl = std::make_shared<Impl>();
  impl->tree = &document->root;
  impl->place = document->root.place;
  impl->document = std::move(document);
  return ConfigNode(std::move(impl));
}

bool ConfigNode::has(const std::string& key) const {
  impl_->remember(key, Impl::Existence{});
  return impl_->entry(key) != nullptr;
}

bool ConfigNode::is_mapping(const std::string& key) const {
  const ConfigEntry* found = impl_->entry(key);
  return found != nullptr && found->value.kind == Kind::mapping;
}

bool ConfigNode::is_list(const std::string& key) const {
  const ConfigEntry* found = impl_->entry(key);
  return found != nullptr && found->value.kind == Kind::list;
}

double ConfigNode::quantity(const std::string& key, Dimension dimension,
                            std::optional<double> fallback) {
  return impl_->quantity(key, fallback, {.dimension = dimension});
}

double ConfigNode::positive(const std::string& key, Dimension dimension,
                            std::optional<double> fallback) {
  const double value =
      impl_->quantity(key, fallback, {.dimension = dimension, .low = 0, .above_low = true});
  if (!(value > 0)) fail(key, "must be positive");
  return value;
}

double ConfigNode::not_negative(const std::string& key, Dimension dimension,
                                std::optional<double> fallback) {
  const double value = impl_->quantity(key, fallback, {.dimension = dimension, .low = 0});
  if (!(value >= 0)) fail(key, "must not be negative");
  return value;
}

Range ConfigNode::range(const std::string& key, Dimension dimension,
                        std::optional<Range> fallback) {
  const std::string wanted = wanted_text(dimension) + " or a list [low, high]";
  Range answer = fallback.value_or(Range{});
  if (const ConfigTree* value = impl_->value(key, wanted, fallback.has_value())) {
    if (value->kind == Kind::scalar) {
      answer.low = answer.high = impl_->number(*value, key, dimension);
    } else if (value->kind == Kind::list && value->items.size() == 2) {
      const auto ends = impl_->numbers(*value, key, dimension);
      answer = {ends[0], ends[1]};
    } else if (value->kind == Kind::list) {
      impl_->refuse_value(
          *value, key, fmt::format("{} is wanted, not a list of {}", wanted, value->items.size()));
    } else {
      impl_->scalar(*value, key, wanted);
    }
    if (answer.low > answer.high) {
      impl_->refuse_value(
          *value, key,
          fmt::format("the range begins at {} and ends below it, at {}", answer.low, answer.high),
          "write [low, high]");
    }
  }
  impl_->answer(key,
                answer.low == answer.high ? yaml_quantity(answer.low, dimension)
                                          : yaml_quantities({answer.low, answer.high}, dimension),
                {.kind = "range", .dimension = dimension, .optional = fallback.has_value()});
  return answer;
}

std::vector<Range> ConfigNode::ranges(const std::string& key, Dimension dimension,
                                      std::size_t count) {
  const std::string wanted = fmt::format("a list of {} elements, each {} or a list [low, high],",
                                         count, wanted_text(dimension));
  const ConfigTree* value = impl_->value(key, wanted, false);
  if (value->kind != Kind::list || value->items.size() != count) {
    impl_->refuse_value(*value, key, fmt::format("{} is wanted", wanted));
  }
  std::vector<Range> answer;
  std::vector<std::string> texts;
  const std::vector<ConfigTree> items = impl_->with_own_units(*value, key);
  for (std::size_t i = 0; i < count; ++i) {
    const ConfigTree& item = items[i];
    const std::string name = fmt::format("{}[{}]", key, i);
    const std::vector<double> ends =
        item.kind == Kind::list ? impl_->numbers(item, name, dimension)
                                : std::vector<double>{impl_->number(item, name, dimension)};
    if (ends.empty() || ends.size() > 2 || ends.front() > ends.back()) {
      impl_->refuse_value(item, name, "one value or a rising list [low, high] is wanted");
    }
    answer.push_back({ends.front(), ends.back()});
    texts.push_back(ends.front() == ends.back()
                        ? yaml_quantity(ends.front(), dimension).value
                        : yaml_quantities({ends.front(), ends.back()}, dimension).value);
  }
  impl_->answer(key, ConfigText{fmt::format("[{}]", fmt::join(texts, ", ")), ""},
                {.kind = "ranges", .dimension = dimension, .count = count});
  return answer;
}

std::vector<double> ConfigNode::quantities(const std::string& key, Dimension dimension,
                                           std::size_t count,
                                           const std::optional<std::vector<double>>& fallback) {
  const std::string wanted =
      (count > 0 ? fmt::format("a list of {} values", count) : std::string("a list of values")) +
      (dimension == Dimension::none ? "" : " in " + unit_name(dimension));
  std::vector<double> answer = fallback.value_or(std::vector<double>{});
  if (const ConfigTree* value = impl_->value(key, wanted, fallback.has_value())) {
    if (value->kind != Kind::list) {
      impl_->refuse_value(*value, key, fmt::format("{} is wanted", wanted), "write [a, b, ...]");
    }
    if (count > 0 && value->items.size() != count) {
      impl_->refuse_value(*value, key,
                          fmt::format("{} is wanted, not of {}", wanted, value->items.size()));
    }
    answer = impl_->numbers(*value, key, dimension);
  }
  impl_->answer(key, yaml_quantities(answer, dimension),
                {.kind = "quantities",
                 .dimension = dimension,
                 .count = count,
                 .optional = fallback.has_value()});
  return answer;
}

std::vector<std::vector<double>> ConfigNode::rows(const std::string& key, Dimension dimension,
                                                  std::size_t count,
                                                  const std::vector<double>& fallback) {
  const std::string wanted = fmt::format("a list of {} values, or a list of such lists,", count);
  std::vector<std::vector<double>> answer = {fallback};
  if (const ConfigTree* value = impl_->value(key, wanted, true)) {
    const bool nested = value->kind == Kind::list && !value->items.empty() &&
                        value->items.front().kind == Kind::list;
    answer.clear();
    for (const ConfigTree& item : nested ? value->items : std::vector<ConfigTree>{*value}) {
      if (item.kind != Kind::list || item.items.size() != count) {
        impl_->refuse_value(item, key, wanted + " is wanted");
      }
      answer.push_back(impl_->numbers(item, key, dimension));
    }
  }
  std::vector<std::string> texts;
  for (const std::vector<double>& row : answer) {
    texts.push_back(yaml_quantities(row, dimension).value);
  }
  const std::string text =
      texts.size() == 1 ? texts.front() : fmt::format("[{}]", fmt::join(texts, ", "));
  impl_->answer(key, ConfigText{text, ""},
                {.kind = "rows", .dimension = dimension, .count = count, .optional = true});
  return answer;
}

std::vector<double> ConfigNode::square_matrix(const std::string& key, Dimension dimension,
                                              std::size_t count) {
  const std::string wanted = fmt::format("a list of {0} lists of {0} values", count);
  std::vector<double> answer;
  std::vector<std::string> rows;
  if (const ConfigTree* value = impl_->value(key, wanted, false)) {
    if (value->kind != Kind::list || value->items.size() != count)
      impl_->refuse_value(*value, key, wanted + " is wanted");
    for (const ConfigTree& item : value->items) {
      if (item.kind != Kind::list || item.items.size() != count)
        impl_->refuse_value(item, key, wanted + " is wanted");
      const std::vector<double> row = impl_->numbers(item, key, dimension);
      answer.insert(answer.end(), row.begin(), row.end());
      rows.push_back(yaml_quantities(row, dimension).value);
    }
  }
  impl_->answer(key, ConfigText{fmt::format("[{}]", fmt::join(rows, ", ")), ""},
                {.kind = "square_matrix", .dimension = dimension, .count = count});
  return answer;
}

namespace {

/// Whole number in decimal digits, or as 1e6; nothing when the text is not one.
std::optional<std::int64_t> whole_number(const std::string& text, bool& too_large) {
  const std::string_view digits =
      std::string_view(text).substr(text.starts_with('+') && !text.starts_with("+-") ? 1 : 0);
  const char* last = digits.data() + digits.size();
  std::int64_t whole = 0;
  const auto exact = std::from_chars(digits.data(), last, whole);
  if (exact.ec == std::errc() && exact.ptr == last) return whole;
  double real = 0;
  const auto rounded = std::from_chars(digits.data(), last, real);
  const bool number = rounded.ptr == last && !digits.empty() &&
                      (rounded.ec == std::errc() ? std::isfinite(real)
                                                 : rounded.ec == std::errc::result_out_of_range);
  too_large = number && (rounded.ec != std::errc() || std::abs(real) > 0x1p53);
  if (!number || too_large || real != std::floor(real)) return {};
  return static_cast<std::int64_t>(real);
}

}  // namespace

std::int64_t ConfigNode::integer(const std::string& key, std::int64_t low, std::int64_t high,
                                 std::optional<std::int64_t> fallback) {
  std::int64_t answer = fallback.value_or(0);
  const std::string wanted = fmt::format("a whole number from {} to {}", low, high);
  if (const ConfigTree* value = impl_->value(key, wanted, fallback.has_value())) {
    const std::string& text = impl_->scalar(*value, key, wanted);
    bool too_large = false;
    const auto whole = whole_number(text, too_large);
    if (!whole && !too_large) {
      impl_->refuse_value(*value, key, fmt::format("{} is wanted, not \"{}\"", wanted, text));
    }
    if (too_large || *whole < low || *whole > high) {
      impl_->refuse_value(*value, key,
                          fmt::format("{} is out of range; {} is wanted", text, wanted));
    }
    answer = *whole;
  }
  impl_->answer(key, ConfigText{fmt::format("{}", answer), ""},
                {.kind = "integer",
                 .low = static_cast<double>(low),
                 .high = static_cast<double>(high),
                 .optional = fallback.has_value()});
  return answer;
}

bool ConfigNode::flag(const std::string& key, bool fallback) {
  bool answer = fallback;
  if (const ConfigTree* value = impl_->value(key, "true or false", true)) {
    std::string text = impl_->scalar(*value, key, "true or false");
    for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    const bool yes = text == "true" || text == "yes" || text == "on";
    if (!yes && text != "false" && text != "no" && text != "off") {
      impl_->refuse_value(*value, key,
                          fmt::format("true or false is wanted, not \"{}\"", value->scalar));
    }
    answer = yes;
  }
  impl_->answer(key, ConfigText{answer ? "true" : "false", ""}, {.kind = "flag", .optional = true});
  return answer;
}

std::string ConfigNode::text(const std::string& key, const std::optional<std::string>& fallback) {
  std::string answer = fallback.value_or("");
  if (const ConfigTree* value = impl_->value(key, "a text", fallback.has_value())) {
    answer = impl_->scalar(*value, key, "a text");
  }
  impl_->answer(key, ConfigText{yaml_text(answer), ""},
                {.kind = "text", .optional = fallback.has_value()});
  return answer;
}

std::string ConfigNode::choice(const std::string& key, const std::vector<std::string>& allowed,
                               const std::optional<std::string>& fallback) {
  const std::string wanted = fmt::format("one of {}", fmt::join(allowed, ", "));
  std::string answer = fallback.value_or("");
  if (const ConfigTree* value = impl_->value(key, wanted, fallback.has_value())) {
    answer = impl_->scalar(*value, key, wanted);
    if (std::find(allowed.begin(), allowed.end(), answer) == allowed.end()) {
      const std::string near = nearest_name(answer, allowed);
      impl_->refuse_value(
          *value, key,
          fmt::format("unknown value \"{}\"{}", answer,
                      near.empty() ? std::string() : fmt::format("; did you mean \"{}\"?", near)),
          wanted);
    }
  }
  impl_->answer(key, ConfigText{yaml_text(answer), ""},
                {.kind = "choice", .allowed = allowed, .optional = fallback.has_value()});
  return answer;
}

std::vector<std::string> ConfigNode::texts(
    const std::string& key, const std::optional<std::vector<std::string>>& fallback) {
  std::vector<std::string> answer = fallback.value_or(std::vector<std::string>{});
  const std::string wanted = "a text or a list of texts";
  if (const ConfigTree* value = impl_->value(key, wanted, fallback.has_value())) {
    answer.clear();
    if (value->kind == Kind::list) {
      for (std::size_t i = 0; i < value->items.size(); ++i) {
        answer.push_back(impl_->scalar(value->items[i], fmt::format("{}[{}]", key, i), "a text"));
      }
    } else {
      answer.push_back(impl_->scalar(*value, key, wanted));
    }
  }
  std::vector<std::string> quoted;
  for (const std::string& one : answer) quoted.push_back(yaml_text(one));
  impl_->answer(key, ConfigText{fmt::format("[{}]", fmt::join(quoted, ", ")), ""},
                {.kind = "texts", .optional = fallback.has_value()});
  return answer;
}

std::vector<std::string> ConfigNode::keys() const {
  impl_->answer("", Impl::Existence{}, {.kind = "names"});
  return impl_->names();
}

ConfigNode ConfigNode::child(const std::string& key) {
  if (const auto* before = impl_->find_asked(key)) {
    if (const auto* same = std::get_if<Impl::Pointer>(&before->answer)) return ConfigNode(*same);
  }
  const ConfigEntry* entry = impl_->entry(key);
  const ConfigTree* tree = entry != nullptr ? &entry->value : nullptr;
  if (tree != nullptr && tree->kind != Kind::mapping && tree->kind != Kind::nothing) {
    impl_->refuse_value(*tree, key, "a mapping of keys is wanted",
                        "write its keys indented below it");
  }
  auto child =
      impl_->below(tree, tree != nullptr ? tree->place : impl_->place, impl_->path_of(key), {key});
  impl_->answer(key, child, {.kind = "child", .optional = true});
  return ConfigNode(std::move(child));
}

std::vector<ConfigNode> ConfigNode::children(const std::string& key) {
  std::vector<Impl::Pointer> list;
  const auto* before = impl_->find_asked(key);
  if (before != nullptr && std::holds_alternative<std::vector<Impl::Pointer>>(before->answer)) {
    list = std::get<std::vector<Impl::Pointer>>(before->answer);
  } else {
    const ConfigEntry* entry = impl_->entry(key);
    if (entry != nullptr && entry->value.kind != Kind::nothing) {
      if (entry->value.kind != Kind::list) {
        impl_->refuse_value(entry->value, key, "a list of mappings is wanted",
                            "begin each element with \"- \"");
      }
      for (const ConfigTree& item : entry->value.items) {
        const std::string name = fmt::format("{}[{}]", key, list.size());
        if (item.kind != Kind::mapping && item.kind != Kind::nothing) {
          impl_->refuse_value(item, name, "a mapping of keys is wanted");
        }
        list.push_back(impl_->below(&item, item.place, impl_->path_of(name),
                                    {key, fmt::format("[{}]", list.size())}));
      }
    }
    impl_->answer(key, list, {.kind = "children", .optional = true});
  }
  std::vector<ConfigNode> nodes;
  for (const Impl::Pointer& item : list) nodes.push_back(ConfigNode(item));
  return nodes;
}

void ConfigNode::leave_alone(const std::vector<std::string>& keys) {
  impl_->left_alone.insert(impl_->left_alone.end(), keys.begin(), keys.end());
}

void ConfigNode::finish() const {
  impl_->refuse_unknown_keys();
}

void ConfigNode::fail(const std::string& key, const std::string& message,
                      const std::string& hint) const {
  const ConfigEntry* entry = key.empty() ? nullptr : impl_->entry(key);
  impl_->refuse(entry != nullptr ? entry->value.place : impl_->place, impl_->path_of(key), message,
                hint);
}

std::string ConfigNode::where(const std::string& key) const {
  const ConfigEntry* entry = impl_->entry(key);
  if (entry == nullptr) return "";
  const ConfigPlace& place = entry->key_place;
  if (!place.override_by.empty()) return place.text("");
  return fmt::format("{}:{}", std::filesystem::path(impl_->document->file_name).filename().string(),
                     place.line);
}

std::string ConfigNode::path() const {
  return impl_->path;
}

std::string ConfigNode::resolved() const {
  std::string text;
  for (const std::string& line : impl_->lines()) text += line + "\n";
  return text.empty() ? "{}\n" : text;
}

std::string path_beside(const std::string& file_name, const std::string& path) {
  return (std::filesystem::path(file_name).parent_path() / path).string();
}

std::string read_text_file(const std::string& path) {
  const WhatIs what = what_is(path);
  if (what.name == "missing") {
    throw FileError(fmt::format("{}: no such file", path), "a configuration is a YAML file");
  }
  if (what.name != "a file" && what.name != "a configuration" && what.name != "no file") {
    throw FileError(fmt::format("{} is {}; a YAML configuration is wanted", path, what.name),
                    what.takes);
  }
  return read_file(path);
}

}  // namespace carillon::core
