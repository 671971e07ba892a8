#pragma once

#include <string>
#include <vector>

namespace carillon::core {

/// Where a value of a configuration was written.
struct ConfigPlace {
  int line = 1;             ///< counted from 1
  int column = 1;           ///< counted from 1
  std::string override_by;  ///< `key=value` of the --set that wrote it; empty: the file did

  /// "smoke.yaml:14:7", or "--set audio.seconds=2".
  std::string text(const std::string& file_name) const;
};

struct ConfigEntry;

/// A YAML document as plain data: aliases and merge keys (`<<`) are followed, every value knows
/// its place, and no key stands twice in a mapping.
struct ConfigTree {
  enum class Kind { nothing, scalar, list, mapping };
  Kind kind = Kind::nothing;
  ConfigPlace place;
  std::string scalar;                ///< text of a scalar, quotes removed
  std::vector<ConfigTree> items;     ///< of a list
  std::vector<ConfigEntry> entries;  ///< of a mapping, in the order of the document

  /// The entry with this key, or null.
  const ConfigEntry* find(const std::string& key) const;
  ConfigEntry* find(const std::string& key);
};

struct ConfigEntry {
  std::string key;
  ConfigPlace key_place;
  ConfigTree value;
};

/// @throws ConfigError  malformed YAML, several documents, a key twice or one that is not a text,
///                      a root that is no mapping, nesting or aliases without bound
ConfigTree parse_config_tree(const std::string& text, const std::string& file_name);

/// Sets one value by `key=value` (`audio.seconds=2`, `objects[0].count=1`). Missing keys are made;
/// an index may be one past the end, which appends.
/// @throws ConfigError  not of that form, or the path leads through something else
void apply_override(ConfigTree& root, const std::string& assignment);

}  // namespace carillon::core
