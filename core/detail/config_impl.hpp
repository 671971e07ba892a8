#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/config.hpp"
#include "core/config_record.hpp"
#include "core/config_text.hpp"
#include "core/config_tree.hpp"

namespace carillon::core {

/// One mapping of a document and what was asked of it; no part of the door.
struct ConfigNode::Impl {
  struct Document {
    std::string file_name;
    ConfigTree root;
  };
  /// Only whether the key exists was asked.
  struct Existence {};
  using Pointer = std::shared_ptr<Impl>;
  /// What was answered: a value as YAML text, one mapping, or a list of mappings.
  using Answer = std::variant<Existence, ConfigText, Pointer, std::vector<Pointer>>;
  struct Asked {
    std::string key;
    Answer answer;
  };

  std::shared_ptr<const Document> document;
  const ConfigTree* tree = nullptr;  ///< null when the mapping is missing
  ConfigPlace place;                 ///< of the mapping, or of the nearest one that exists
  std::string path;
  std::vector<std::string> steps;  ///< the same in its parts, as ConfigRecord hears it
  std::vector<Asked> asked;        ///< in the order of asking
  std::vector<std::string> left_alone;

  std::string path_of(const std::string& key) const;
  const ConfigEntry* entry(const std::string& key) const;
  std::vector<std::string> names() const;

  Asked* find_asked(const std::string& key);
  const Asked* find_asked(const std::string& key) const;
  void remember(const std::string& key, Answer answer);
  /// Remembers what was answered, and lets it be heard.
  void answer(const std::string& key, Answer answer, const ConfigAsk& ask);
  double quantity(const std::string& key, std::optional<double> fallback, ConfigAsk ask);

  /// Throws `place: full_path: message`.
  [[noreturn]] void refuse(const ConfigPlace& where, const std::string& full_path,
                           const std::string& message, const std::string& hint = {}) const;
  [[noreturn]] void refuse_value(const ConfigTree& value, const std::string& key,
                                 const std::string& message, const std::string& hint = {}) const;
  [[noreturn]] void refuse_missing(const std::string& key, const std::string& wanted) const;
  void refuse_unknown_keys() const;

  /// The value under a key; null when it is missing and may be.
  /// @param wanted  what the key holds, for messages: "a value in m"
  const ConfigTree* value(const std::string& key, const std::string& wanted, bool optional) const;
  const std::string& scalar(const ConfigTree& value, const std::string& key,
                            const std::string& wanted) const;
  double number(const ConfigTree& value, const std::string& key, Dimension dimension) const;
  /// The elements of a list, with the unit behind its last one on all of them; those that are lists
  /// themselves have their own.
  std::vector<ConfigTree> with_own_units(const ConfigTree& list, const std::string& key) const;
  std::vector<double> numbers(const ConfigTree& list, const std::string& key,
                              Dimension dimension) const;

  /// A mapping below this one, nothing asked of it yet.
  /// @param further  steps from this one to it
  Pointer below(const ConfigTree* value, const ConfigPlace& where, std::string name,
                const std::vector<std::string>& further) const;

  /// The resolved mapping, not indented.
  std::vector<std::string> lines() const;
};

/// "a number", or "a value in m".
std::string wanted_text(Dimension dimension);

}  // namespace carillon::core
