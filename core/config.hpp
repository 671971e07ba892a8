#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "core/units.hpp"

namespace carillon::core {

/// One mapping of a YAML configuration, read by asking for its keys.
///
/// Asking states the schema: key, type, dimension, default. `finish()` then refuses every key that
/// nobody asked for, naming the nearest one that exists. Every answer, defaults included, is
/// remembered, so that the resolved configuration can be written beside the results. Every error
/// is a ConfigError of the form `file:line:column: objects[0].lenght: ...`.
class ConfigNode {
 public:
  /// @param text       YAML document; its root must be a mapping
  /// @param file_name  for messages
  /// @param overrides  `key=value` with dotted keys (`audio.seconds=2`, `objects[0].count=1`),
  ///                   applied before anything is read; a message about one names `--set`
  static ConfigNode parse(const std::string& text, const std::string& file_name,
                          const std::vector<std::string>& overrides = {});

  bool has(const std::string& key) const;
  /// Whether the value under `key` is a mapping, for keys that take a mapping or something else.
  bool is_mapping(const std::string& key) const;
  /// Whether it is a list, for keys that take one value or many.
  bool is_list(const std::string& key) const;

  /// Without a default, a missing key is an error that names the key and its unit.
  double quantity(const std::string& key, Dimension dimension, std::optional<double> fallback = {});
  double positive(const std::string& key, Dimension dimension, std::optional<double> fallback = {});
  double not_negative(const std::string& key, Dimension dimension,
                      std::optional<double> fallback = {});
  /// A value, or a list [low, high].
  Range range(const std::string& key, Dimension dimension, std::optional<Range> fallback = {});
  /// A list of `count` elements, each a value or a list [low, high].
  std::vector<Range> ranges(const std::string& key, Dimension dimension, std::size_t count);
  /// A list of exactly `count` values with units (count 0: any number).
  std::vector<double> quantities(const std::string& key, Dimension dimension, std::size_t count = 0,
                                 const std::optional<std::vector<double>>& fallback = {});
  /// A list of `count` values, or a list of such lists.
  std::vector<std::vector<double>> rows(const std::string& key, Dimension dimension,
                                        std::size_t count, const std::vector<double>& fallback);
  /// A list of `count` lists of as many values, row by row.
  std::vector<double> square_matrix(const std::string& key, Dimension dimension, std::size_t count);
  std::int64_t integer(const std::string& key, std::int64_t low, std::int64_t high,
                       std::optional<std::int64_t> fallback = {});
  bool flag(const std::string& key, bool fallback);
  std::string text(const std::string& key, const std::optional<std::string>& fallback = {});
  /// One of `allowed`; the error names the nearest.
  std::string choice(const std::string& key, const std::vector<std::string>& allowed,
                     const std::optional<std::string>& fallback = {});
  /// A text or a list of texts.
  std::vector<std::string> texts(const std::string& key,
                                 const std::optional<std::vector<std::string>>& fallback = {});
  /// Keys of this mapping in their order, for mappings whose keys are names chosen by the user.
  std::vector<std::string> keys() const;

  /// The mapping under `key`; an empty one when the key is missing (its defaults are recorded).
  ConfigNode child(const std::string& key);
  /// The mappings in the list under `key`; a missing key gives an empty list.
  std::vector<ConfigNode> children(const std::string& key);

  /// Lets keys stand unread that mean something to another reader of the same document.
  void leave_alone(const std::vector<std::string>& keys);

  /// Refuses keys that were never asked for, here and in every child that was asked for.
  void finish() const;

  /// Throws a ConfigError that points at `key` (or at this mapping, for "").
  [[noreturn]] void fail(const std::string& key, const std::string& message,
                         const std::string& hint = {}) const;

  /// Where `key` was written, e.g. `smoke.yaml:14` or `--set room.order=2`; "" when it is missing.
  std::string where(const std::string& key) const;

  /// Path of this node, e.g. `objects[0]`; "" for the root.
  std::string path() const;

  /// Everything that was asked for with the value that was answered, as YAML in SI units.
  /// Keys in the order of asking; equal configurations give equal texts.
  std::string resolved() const;

 private:
  struct Impl;
  explicit ConfigNode(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

/// What `check` returns; what it throws becomes a ConfigError that points at a key.
template <class Check>
auto at_key(const ConfigNode& node, const std::string& key, Check&& check) {
  try {
    return check();
  } catch (const ConfigError&) {
    throw;
  } catch (const Error& error) {
    node.fail(key, error.message(), error.hint());
  }
}

/// A path in a configuration, which is meant from where that file lies.
std::string path_beside(const std::string& file_name, const std::string& path);

/// Text of a file, for `ConfigNode::parse`.
/// @throws FileError  with the system's reason
std::string read_text_file(const std::string& path);

}  // namespace carillon::core
