#include "core/config_tree.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <exception>
#include <utility>

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

// A few lines of aliases to aliases can unfold into billions of values, and an alias inside its
// own anchor has no end.
constexpr int deepest_nesting = 64;
constexpr int most_values = 1'000'000;

class Conversion {
 public:
  /// @param override_by  the --set that holds the text; empty for a file
  Conversion(std::string file_name, std::string override_by)
      : file_name_(std::move(file_name)), override_by_(std::move(override_by)) {}

  ConfigTree document(const std::string& text) {
    std::vector<YAML::Node> documents;
    try {
      documents = YAML::LoadAll(text);
      if (documents.empty()) return {Kind::nothing, place(YAML::Mark()), {}, {}, {}};
      if (documents.size() > 1) {
        fail(place(documents[1].Mark()), "",
             "a second YAML document begins; a configuration is one document");
      }
      return convert(documents[0], "", 0);
    } catch (const YAML::Exception& error) {
      const ConfigPlace where = place(error.mark);
      const bool tab = override_by_.empty() && tab_indents(text, where.line);
      fail(where, "", "malformed YAML: " + error.msg,
           tab ? "YAML forbids tabs in indentation; use spaces" : "");
    } catch (const Error&) {
      throw;
    } catch (const std::exception& error) {
      fail(place(YAML::Mark()), "", fmt::format("malformed YAML: {}", error.what()));
    }
  }

 private:
  [[noreturn]] void fail(const ConfigPlace& where, const std::string& path,
                         const std::string& message, const std::string& hint = {}) const {
    const std::string start = where.text(file_name_) + ": ";
    throw ConfigError(start + (path.empty() ? "" : path + ": ") + message, hint);
  }

  ConfigPlace place(const YAML::Mark& mark) const {
    ConfigPlace where;
    where.override_by = override_by_;
    if (!mark.is_null()) {
      where.line = mark.line + 1;
      where.column = mark.column + 1;
    }
    return where;
  }

  static bool tab_indents(const std::string& text, int line) {
    std::size_t start = 0;
    for (int i = 1; i < line && start != std::string::npos; ++i) {
      start = text.find('\n', start);
      if (start != std::string::npos) ++start;
    }
    if (start == std::string::npos) return false;
    const std::size_t first = text.find_first_not_of(" \t", start);
    return text.substr(start, first - start).find('\t') != std::string::npos;
  }

  ConfigTree convert(const YAML::Node& node, const std::string& path, int depth) {
    ConfigTree tree;
    tree.place = place(node.Mark());
    if (depth > deepest_nesting) {
      fail(tree.place, "", fmt::format("nested more than {} deep", deepest_nesting));
    }
    if (++values_ > most_values) {
      fail(tree.place, "", fmt::format("more than {} values (aliases unfolded)", most_values));
    }
    switch (node.Type()) {
      case YAML::NodeType::Undefined:
      case YAML::NodeType::Null:
        break;
      case YAML::NodeType::Scalar:
        tree.kind = Kind::scalar;
        tree.scalar = node.Scalar();
        break;
      case YAML::NodeType::Sequence:
        tree.kind = Kind::list;
        for (const YAML::Node& item : node) {
          const std::string name = fmt::format("{}[{}]", path, tree.items.size());
          tree.items.push_back(convert(item, name, depth + 1));
        }
        break;
      case YAML::NodeType::Map:
        tree.kind = Kind::mapping;
        convert_entries(node, path, depth, tree);
        break;
    }
    return tree;
  }

  void convert_entries(const YAML::Node& node, const std::string& path, int depth,
                       ConfigTree& tree) {
    std::vector<ConfigTree> merged;
    for (const auto& pair : node) {
      ConfigEntry entry;
      entry.key_place = place(pair.first.Mark());
      if (!pair.first.IsScalar()) fail(entry.key_place, path, "a key must be a text");
      entry.key = pair.first.Scalar();
      const std::string name = path.empty() ? entry.key : path + "." + entry.key;
      entry.value = convert(pair.second, name, depth + 1);
      if (entry.key == "<<") {
        merged.push_back(std::move(entry.value));
        continue;
      }
      if (const ConfigEntry* first = tree.find(entry.key)) {
        fail(entry.key_place, name,
             fmt::format("the key stands twice; first at line {}, column {}", first->key_place.line,
                         first->key_place.column));
      }
      tree.entries.push_back(std::move(entry));
    }
    for (const ConfigTree& source : merged) merge(source, path, tree);
  }

  /// Merge key: adds the entries of a mapping, or of each in a list, that are not there yet.
  void merge(const ConfigTree& source, const std::string& path, ConfigTree& into) const {
    if (source.kind == Kind::list) {
      for (const ConfigTree& item : source.items) merge(item, path, into);
      return;
    }
    if (source.kind != Kind::mapping) {
      fail(source.place, path, "`<<` merges a mapping or a list of mappings");
    }
    for (const ConfigEntry& entry : source.entries) {
      if (into.find(entry.key) == nullptr) into.entries.push_back(entry);
    }
  }

  std::string file_name_;
  std::string override_by_;
  int values_ = 0;
};

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
  ConfigTree root = Conversion(file_name, "").document(text);
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
  ConfigTree value = Conversion("", assignment).document(assignment.substr(equals + 1));

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
