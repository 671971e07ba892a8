#include "dataset/sweep/sweep.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/config.hpp"
#include "core/random.hpp"
#include "dataset/sweep/detail/values.hpp"

namespace carillon::dataset::sweep {

using core::ConfigError;
using core::ConfigNode;
using core::ConfigTree;
using Kind = ConfigTree::Kind;

namespace {

/// A swept key, where it stands, and what it takes.
struct SweptKey {
  std::string name;
  std::string shown;  ///< where it is written, from the root
  std::string place;
  SweepAxis axis{};
  std::vector<std::string> places{};  ///< of the values
};

/// Whether `inner` is `outer` itself or lies within it: room.rt60 in room, objects[0] in objects.
bool lies_within(const std::string& inner, const std::string& outer) {
  return inner.starts_with(outer) &&
         (inner.size() == outer.size() || inner[outer.size()] == '.' || inner[outer.size()] == '[');
}

[[noreturn]] void refuse(const SweptKey& key, const std::string& message,
                         const std::string& hint = {}) {
  throw ConfigError(fmt::format("{}: {}: {}", key.place, key.shown, message), hint);
}

/// Adds one value where it stands.
void add_value(SweptKey& key, const ConfigTree& item, const std::string& label,
               const std::string& file_name) {
  if (item.kind == Kind::nothing) refuse(key, "has an empty value", "write one, or leave it out");
  const std::string text = flow_text(item);
  key.axis.values.push_back({text, label.empty() ? text : label});
  key.places.push_back(item.place.text(file_name));
}

/// A range, or values with names.
void read_mapping(SweptKey& key, const ConfigTree& value, ConfigNode node,
                  const std::string& file_name) {
  if (const core::ConfigEntry* named = value.find("named")) {
    if (named->value.kind != Kind::mapping) refuse(key, "`named` is a mapping of names to values");
    node.leave_alone({"named"});
    node.finish();
    for (const core::ConfigEntry& one : named->value.entries) {
      add_value(key, one.value, one.key, file_name);
    }
    return;
  }
  if (value.find("from") == nullptr && value.find("to") == nullptr) {
    refuse(
        key, "a list of values, a range {from, to, count} or {named: {name: value}} is wanted",
        "keys are dotted, as in modes.order: [2, 3]; a value that is a mapping stands in a list");
  }
  key.axis.range = read_range(std::move(node));
  key.axis.values = values_of(*key.axis.range);
  key.places.assign(key.axis.values.size(), value.place.text(file_name));
}

SweptKey read_key(const core::ConfigEntry& entry, ConfigNode& keys, const std::string& file_name,
                  const SweepPlace& place, bool random) {
  SweptKey key{place.prefix + entry.key, place.text() + ".keys." + entry.key,
               entry.key_place.text(file_name)};
  const ConfigTree& value = entry.value;
  if (value.kind == Kind::mapping) {
    read_mapping(key, value, keys.child(entry.key), file_name);
  } else if (value.kind == Kind::list) {
    for (const ConfigTree& item : value.items) add_value(key, item, "", file_name);
  } else {
    add_value(key, value, "", file_name);
  }
  const bool continuous = key.axis.range && key.axis.range->continuous();
  if (continuous && !random) refuse(key, "a range without count or step is for `mode: random`");
  if (key.axis.values.empty() && !continuous) refuse(key, "has no values");
  return key;
}

/// What is set twice would be set by one alone.
void refuse_lost(const std::vector<SweptKey>& keys, const std::vector<std::string>& overrides,
                 const std::string& section) {
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const SweptKey& key = keys[k];
    if (lies_within(key.name, "sweep")) refuse(key, "a sweep cannot sweep itself");
    if (lies_within("ranks.memory_per_node", key.name)) {
      refuse(key, "belongs to the run, which is one for all variants");
    }
    for (const std::string& override_text : overrides) {
      if (!lies_within(override_text.substr(0, override_text.find('=')), key.name)) continue;
      refuse(key, fmt::format("is swept, and set by --set {}", override_text),
             fmt::format("sweep fewer values with --set '{}.keys={{{}: [...]}}', or nothing with "
                         "--set {}=",
                         section, key.shown.substr(section.size() + 6), section));
    }
    for (std::size_t before = 0; before < k; ++before) {
      if (lies_within(keys[before].name, key.name)) {
        refuse(key, fmt::format("overwrites {}, which is swept too", keys[before].name),
               fmt::format("write {} after {}", keys[before].name, key.name));
      }
    }
  }
}

using Row = std::vector<SweepValue>;

std::vector<Row> grid(const std::vector<SweptKey>& keys, const ConfigNode& node) {
  std::size_t product = 1;
  std::string factors;
  for (const SweptKey& key : keys) {
    factors += (factors.empty() ? "" : " x ") + std::to_string(key.axis.values.size());
    product = product > max_variants ? product : product * key.axis.values.size();
  }
  if (product > max_variants) {
    node.fail("keys", fmt::format("{} are more than {} variants", factors, max_variants),
              "sweep fewer values, or draw some of them with `mode: random` and `count`");
  }
  std::vector<Row> rows = {{}};
  for (const SweptKey& key : keys) {
    std::vector<Row> longer;
    for (const Row& row : rows) {
      for (const SweepValue& value : key.axis.values) {
        longer.push_back(row);
        longer.back().push_back(value);
      }
    }
    rows = std::move(longer);
  }
  return rows;
}

std::vector<Row> zip(const std::vector<SweptKey>& keys) {
  std::vector<Row> rows(keys.front().axis.values.size());
  if (rows.size() > max_variants) refuse(keys.front(), "has more values than a sweep may have");
  for (const SweptKey& key : keys) {
    if (key.axis.values.size() != rows.size()) {
      refuse(key,
             fmt::format("has {} values and {} has {}", key.axis.values.size(), keys.front().name,
                         rows.size()),
             "a zip takes the first of every key, then the second, and so on; `mode: grid` takes "
             "every combination");
    }
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].push_back(key.axis.values[i]);
  }
  return rows;
}

std::vector<Row> random_rows(const std::vector<SweptKey>& keys, const Sweep& sweep,
                             const ConfigNode& node) {
  const auto count = static_cast<std::size_t>(sweep.count);
  std::vector<Row> rows;
  std::set<Row> seen;
  const auto tries = static_cast<std::int64_t>(100 * count);
  for (std::int64_t draw = 0; draw < tries && rows.size() < count; ++draw) {
    Row row;
    for (const SweptKey& key : keys) {
      row.push_back(draw_value(key.axis.values, key.axis.range, sweep.seed, key.name, draw));
    }
    if (seen.insert(row).second) rows.push_back(std::move(row));
  }
  if (rows.size() < count) {
    node.fail("count", fmt::format("{} draws gave only {} different variants", tries, rows.size()),
              "ask for fewer, or sweep every combination with `mode: grid`");
  }
  return rows;
}

/// Last part of each key, where no two have the same.
std::vector<std::string> short_names(const std::vector<std::string>& keys) {
  const auto last_part = [](const std::string& key) { return key.substr(key.rfind('.') + 1); };
  std::multiset<std::string> parts;
  for (const std::string& key : keys) parts.insert(last_part(key));
  std::vector<std::string> names;
  for (const std::string& key : keys) {
    const std::string part = last_part(key);
    names.push_back(parts.count(part) == 1 ? part : key);
  }
  return names;
}

/// `order=3,rt60=0.5s`; where letters had to go, a short hash keeps different values apart.
std::string folder_of(const std::vector<std::string>& names, const SweepVariant& variant) {
  constexpr std::size_t longest = 120;
  std::string folder, whole;
  bool changed = false;
  for (std::size_t k = 0; k < names.size(); ++k) {
    std::string value = variant.values[k];
    std::erase(value, ' ');
    std::string safe = names[k] + "=" + value;
    for (char& c : safe) {
      const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                         (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '_' || c == '=';
      changed = changed || !plain;
      c = plain ? c : '_';
    }
    folder += (folder.empty() ? "" : ",") + safe;
    whole += variant.overrides[k] + "\n";
  }
  if (!changed && folder.size() <= longest) return folder;
  return fmt::format("{}-{:08x}", folder.substr(0, longest), core::stable_hash(whole) >> 32);
}

SweepVariant variant_of(const std::vector<std::string>& keys, const Row& row) {
  SweepVariant variant;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    variant.values.push_back(row[k].label);
    variant.overrides.push_back(keys[k] + "=" + row[k].text);
  }
  variant.folder = folder_of(short_names(keys), variant);
  return variant;
}

}  // namespace

std::string SweepPlace::text() const {
  return fmt::format("{}", fmt::join(path, "."));
}

std::optional<Sweep> read_sweep(const std::string& text, const std::string& file_name,
                                const std::vector<std::string>& overrides,
                                const SweepPlace& place) {
  ConfigTree tree = core::parse_config_tree(text, file_name);
  for (const std::string& assignment : overrides) core::apply_override(tree, assignment);
  const core::ConfigEntry* found = nullptr;
  ConfigNode node = ConfigNode::parse(text, file_name, overrides);
  for (const std::string& key : place.path) {
    found = found == nullptr ? tree.find(key) : found->value.find(key);
    if (found == nullptr || found->value.kind == Kind::nothing) return {};
    node = node.child(key);
  }
  Sweep sweep;
  std::vector<std::string> modes = {"grid", "zip", "random"};
  if (place.is_search) modes.emplace_back("parzen");
  sweep.mode = node.choice("mode", modes, "grid");
  const bool draws = sweep.mode == "random" || sweep.mode == "parzen";
  node.leave_alone({"keys"});
  node.leave_alone(place.others);
  if (draws) {
    sweep.count = node.integer("count", 1, static_cast<std::int64_t>(max_variants));
    sweep.seed = static_cast<std::uint64_t>(
        node.integer("seed", 0, std::numeric_limits<std::int64_t>::max(), 0));
  }
  node.finish();
  ConfigNode keys_node = node.child("keys");
  std::vector<SweptKey> keys;
  if (const core::ConfigEntry* listed = found->value.find("keys")) {
    for (const core::ConfigEntry& entry : listed->value.entries) {
      keys.push_back(read_key(entry, keys_node, file_name, place, draws));
    }
  }
  if (keys.empty()) {
    node.fail("keys", "names no key to sweep", "for example keys: {modes.order: [2, 3]}");
  }
  refuse_lost(keys, overrides, place.text());

  for (const SweptKey& key : keys) {
    sweep.keys.push_back(key.name);
    sweep.axes.push_back(key.axis);
    for (std::size_t i = 0; i < key.axis.values.size(); ++i) {
      sweep.places.emplace(key.name + "=" + key.axis.values[i].text, key.places[i]);
    }
  }
  if (sweep.mode == "parzen") return sweep;
  const std::vector<Row> rows = sweep.mode == "grid"  ? grid(keys, node)
                                : sweep.mode == "zip" ? zip(keys)
                                                      : random_rows(keys, sweep, node);
  std::set<std::string> folders;
  for (const Row& row : rows) {
    SweepVariant variant = variant_of(sweep.keys, row);
    // Drawn numbers were not written anywhere; their range was.
    for (std::size_t k = 0; k < keys.size(); ++k) {
      sweep.places.emplace(variant.overrides[k], keys[k].place);
    }
    if (!folders.insert(variant.folder).second) {
      node.fail("keys", fmt::format("the variant {} comes twice", variant.folder),
                "each value stands once");
    }
    sweep.variants.push_back(std::move(variant));
  }
  return sweep;
}

SweepVariant variant_at(const Sweep& sweep, const std::vector<double>& place) {
  Row row;
  for (std::size_t k = 0; k < sweep.axes.size(); ++k) {
    const SweepAxis& axis = sweep.axes[k];
    row.push_back(axis.values.empty() ? value_between(*axis.range, place[k])
                                      : axis.values[static_cast<std::size_t>(place[k])]);
  }
  return variant_of(sweep.keys, row);
}

}  // namespace carillon::dataset::sweep
