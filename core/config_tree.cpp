#include "core/config_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "core/config_reader.hpp"
#include "core/error.hpp"

namespace carillon::core {

std::string ConfigPlace::text(const std::string& file_name) const {
  if (!override_by.empty()) return "--set " + override_by;
  return fmt::format("{}:{}:{}", file_name, line, column);
}

ConfigEntry* ConfigTree::find(const std::string& key) {
  const auto found = std::find_if(entries.begin(), entries.end(),
                                  [&](const ConfigEntry& entry) { return entry.key == key; });
  return found == entries.end() ? nullptr : &*found;
}

const ConfigEntry* ConfigTree::find(const std::string& key) const {
  return const_cast<ConfigTree*>(this)->find(key);
}

namespace {

using Kind = ConfigTree::Kind;

constexpr const char* override_form =
    "write key=value with dotted keys, for example audio.seconds=2 or objects[0].count=1";

[[noreturn]] void refuse(const std::string& assignment, const std::string& message,
                         const std::string& hint = override_form) {
  throw ConfigError("--set " + assignment + ": " + message, hint);
}

/// One step of a path: a key, then the indices that follow it.
struct Step {
  std::string key;
  std::vector<std::size_t> indices;
};

std::vector<Step> steps_of(const std::string& path, const std::string& assignment) {
  std::vector<Step> steps;
  for (std::size_t at = 0; at <= path.size();) {
    const std::size_t dot = std::min(path.find('.', at), path.size());
    const std::string part = path.substr(at, dot - at);
    std::size_t open = std::min(part.find('['), part.size());
    Step step{part.substr(0, open), {}};
    if (step.key.empty()) refuse(assignment, fmt::format("a key is missing in \"{}\"", path));
    while (open < part.size()) {
      const std::size_t close = part.find(']', open);
      const char* last = part.data() + std::min(close, part.size());
      std::size_t index = 0;
      const auto [end, error] = std::from_chars(part.data() + open + 1, last, index);
      const bool another = close + 1 < part.size();
      if (part[open] != '[' || close == std::string::npos || error != std::errc() || end != last ||
          (another && part[close + 1] != '[')) {
        refuse(assignment, fmt::format("\"{}\" is not of the form name[0]", part));
      }
      step.indices.push_back(index);
      open = close + 1;
    }
    steps.push_back(std::move(step));
    at = dot + 1;
  }
  return steps;
}

/// Turns an empty value into one of this kind, or insists that it is of this kind.
void become(ConfigTree& tree, Kind kind, const std::string& name, const ConfigPlace& place) {
  if (tree.kind == Kind::nothing) {
    tree.kind = kind;
    tree.place = place;
  }
  if (tree.kind == kind) return;
  const std::string path = name.empty() ? "the configuration" : name;
  refuse(place.override_by,
         kind == Kind::mapping ? fmt::format("{} is not a mapping of keys", path)
                               : fmt::format("{} is not a list", path),
         tree.kind == Kind::list ? fmt::format("its elements are {}[0] to {}[{}]", path, path,
                                               std::max<std::size_t>(1, tree.items.size()) - 1)
                                 : override_form);
}

}  // namespace

ConfigTree parse_config_tree(const std::string& text, const std::string& file_name) {
  ConfigTree root = read_yaml(text, file_name, "");
  if (root.kind == Kind::nothing) root.kind = Kind::mapping;
  if (root.kind != Kind::mapping) {
    throw ConfigError(root.place.text(file_name) + ": a configuration is a mapping of keys",
                      "write `key: value`, one in a line");
  }
  return root;
}

void apply_override(ConfigTree& root, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) refuse(assignment, "there is no \"=\"");
  const std::string path = assignment.substr(0, equals);
  ConfigPlace place;
  place.override_by = assignment;
  ConfigTree value = read_yaml(assignment.substr(equals + 1), "", assignment);

  ConfigTree* at = &root;
  std::string name;
  for (const Step& step : steps_of(path, assignment)) {
    become(*at, Kind::mapping, name, place);
    name += (name.empty() ? "" : ".") + step.key;
    if (at->find(step.key) == nullptr) at->entries.push_back({step.key, place, {}});
    at = &at->find(step.key)->value;
    for (std::size_t index : step.indices) {
      become(*at, Kind::list, name, place);
      if (index > at->items.size()) {
        refuse(
            assignment,
            fmt::format("{} has {} element{}; the next to append is {}[{}]", name, at->items.size(),
                        at->items.size() == 1 ? "" : "s", name, at->items.size()),
            "elements are counted from 0");
      }
      if (index == at->items.size()) at->items.emplace_back();
      name += fmt::format("[{}]", index);
      at = &at->items[index];
    }
  }
  *at = std::move(value);
  // An empty value must point at the --set, too.
  at->place = place;
}

}  // namespace carillon::core
