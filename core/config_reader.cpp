#include "core/config_reader.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <exception>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.hpp"

namespace carillon::core {

namespace {

using Kind = ConfigTree::Kind;

// A few lines of aliases to aliases can unfold into billions of values.
constexpr std::size_t deepest_nesting = 64;
constexpr std::size_t max_values = 1'000'000;

bool is_continuation(char c) {
  return (static_cast<unsigned char>(c) & 0xc0) == 0x80;
}

/// Bytes of the UTF-8 character that begins here; 0 when none does.
std::size_t character_size(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  const std::size_t size = first < 0x80                    ? 1
                           : first >= 0xc2 && first < 0xe0 ? 2
                           : first >= 0xe0 && first < 0xf0 ? 3
                           : first >= 0xf0 && first < 0xf5 ? 4
                                                           : 0;
  if (size > text.size()) return 0;
  const std::string_view rest = text.substr(0, size).substr(std::min<std::size_t>(1, size));
  return std::all_of(rest.begin(), rest.end(), is_continuation) ? size : 0;
}

/// Builds the tree from the parser's events. yaml-cpp's own nodes are left aside: they keep the
/// first of two equal keys silently, and loading every document of a damaged text may never end.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const std::string& text, const std::string& file_name, const std::string& override_by)
      : text_(text), file_name_(file_name), override_by_(override_by) {}

  ConfigTree take() { return std::move(root_); }

  ConfigPlace place(const YAML::Mark& mark) const {
    ConfigPlace where;
    where.override_by = override_by_;
    if (mark.is_null()) return where;
    where.line = mark.line + 1;
    where.column = mark.column + 1;
    // The parser counts bytes, editors characters.
    const auto end = std::min(static_cast<std::size_t>(std::max(0, mark.pos)), text_.size());
    const auto width = std::min(static_cast<std::size_t>(std::max(0, mark.column)), end);
    where.column -= static_cast<int>(
        std::count_if(text_.begin() + static_cast<std::ptrdiff_t>(end - width),
                      text_.begin() + static_cast<std::ptrdiff_t>(end), is_continuation));
    return where;
  }

  [[noreturn]] void fail(const ConfigPlace& where, const std::string& path,
                         const std::string& message, const std::string& hint = {}) const {
    const std::string start = where.text(file_name_) + ": ";
    throw ConfigError(start + (path.empty() ? "" : path + ": ") + message, hint);
  }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ == 1) return;
    const auto at = std::min(static_cast<std::size_t>(std::max(0, mark.pos)), text_.size());
    const std::string_view rest = std::string_view(text_).substr(at);
    const bool marked = rest.starts_with("---") || rest.starts_with("%");
    fail(place(mark), "",
         marked ? "a second YAML document begins; a configuration is one document"
                : "malformed YAML: this belongs to nothing before it",
         marked ? "" : "a bracket, a comma or an indentation above may be out of place");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    add(leaf(Kind::nothing, mark), anchor);
  }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                const std::string& value) override {
    if (never_closed(mark)) {
      fail(place(mark), next_path(), "malformed YAML: the quote is never closed");
    }
    ConfigTree tree = leaf(Kind::scalar, mark);
    tree.scalar = value;
    add(std::move(tree), anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) {
      fail(place(mark), "", "malformed YAML: an alias stands inside its own anchor");
    }
    count(found->second.values, mark);
    add(ConfigTree(found->second.tree), 0);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(Kind::list, mark, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(Kind::mapping, mark, anchor);
  }
  void OnMapEnd() override {
    for (const ConfigTree& source : open_.back().merged) merge(source, open_.back());
    close();
  }

 private:
  /// A list or a mapping whose end has not come yet.
  struct Open {
    ConfigTree tree;
    YAML::anchor_t anchor;
    std::string path;
    std::size_t values_before;
    std::optional<ConfigEntry> key;  ///< waits for its value
    std::vector<ConfigTree> merged;  ///< values of merge keys
  };
  struct Anchored {
    ConfigTree tree;
    std::size_t values;
  };

  /// yaml-cpp lets the end of the text stand for a closing quote.
  bool never_closed(const YAML::Mark& mark) const {
    std::size_t at = static_cast<std::size_t>(std::max(0, mark.pos));
    if (at >= text_.size()) return false;
    const char quote = text_[at];
    if (quote != '"' && quote != '\'') return false;
    for (++at; at < text_.size(); ++at) {
      if (text_[at] == '\\' && quote == '"') {
        ++at;
      } else if (text_[at] == quote) {
        if (quote == '"' || at + 1 == text_.size() || text_[at + 1] != quote) return false;
        ++at;
      }
    }
    return true;
  }

  void count(std::size_t more, const YAML::Mark& mark) {
    values_ += more;
    if (values_ > max_values) {
      fail(place(mark), "", fmt::format("more than {} values (aliases unfolded)", max_values));
    }
  }

  ConfigTree leaf(Kind kind, const YAML::Mark& mark) {
    count(1, mark);
    ConfigTree tree;
    tree.kind = kind;
    tree.place = place(mark);
    return tree;
  }

  /// Path of the value that comes next.
  std::string next_path() const {
    if (open_.empty()) return "";
    const Open& parent = open_.back();
    if (parent.tree.kind == Kind::list) {
      return fmt::format("{}[{}]", parent.path, parent.tree.items.size());
    }
    if (!parent.key) return parent.path;
    return parent.path.empty() ? parent.key->key : parent.path + "." + parent.key->key;
  }

  void open(Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (open_.size() >= deepest_nesting) {
      fail(place(mark), "", fmt::format("nested more than {} deep", deepest_nesting));
    }
    const std::size_t before = values_;
    std::string path = next_path();
    open_.push_back({leaf(kind, mark), anchor, std::move(path), before, {}, {}});
  }

  void close() {
    Open done = std::move(open_.back());
    open_.pop_back();
    if (done.anchor != 0) anchors_[done.anchor] = {done.tree, values_ - done.values_before};
    add(std::move(done.tree), 0);
  }

  void add(ConfigTree tree, YAML::anchor_t anchor) {
    if (anchor != 0) anchors_[anchor] = {tree, 1};
    if (open_.empty()) {
      root_ = std::move(tree);
    } else if (Open& parent = open_.back(); parent.tree.kind == Kind::list) {
      parent.tree.items.push_back(std::move(tree));
    } else if (!parent.key) {
      if (tree.kind != Kind::scalar) fail(tree.place, parent.path, "a key must be a text");
      parent.key = ConfigEntry{std::move(tree.scalar), std::move(tree.place), {}};
      refuse_twice(parent);
    } else {
      parent.key->value = std::move(tree);
      if (parent.key->key == "<<") {
        parent.merged.push_back(std::move(parent.key->value));
      } else {
        parent.tree.entries.push_back(std::move(*parent.key));
      }
      parent.key.reset();
    }
  }

  void refuse_twice(const Open& parent) const {
    const ConfigEntry* first = parent.tree.find(parent.key->key);
    if (first == nullptr) return;
    fail(parent.key->key_place, next_path(),
         fmt::format("the key stands twice; first at line {}, column {}", first->key_place.line,
                     first->key_place.column));
  }

  /// Merge key: adds the entries of a mapping, or of each in a list, that are not there yet.
  void merge(const ConfigTree& source, Open& into) const {
    if (source.kind == Kind::list) {
      for (const ConfigTree& item : source.items) merge(item, into);
      return;
    }
    if (source.kind != Kind::mapping) {
      fail(source.place, into.path, "`<<` merges a mapping or a list of mappings");
    }
    for (const ConfigEntry& entry : source.entries) {
      if (into.tree.find(entry.key) == nullptr) into.tree.entries.push_back(entry);
    }
  }

  const std::string& text_;
  const std::string& file_name_;
  const std::string& override_by_;
  int documents_ = 0;
  std::size_t values_ = 0;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, Anchored> anchors_;
  ConfigTree root_;
};

/// yaml-cpp would replace what is not UTF-8, end silently at a control character, and count
/// places differently afterwards.
void refuse_other_encodings(const std::string& text, const TreeBuilder& builder,
                            const std::string& override_by) {
  ConfigPlace where;
  where.override_by = override_by;
  for (std::size_t at = 0; at < text.size();) {
    const auto code = static_cast<unsigned char>(text[at]);
    const std::size_t size = character_size(std::string_view(text).substr(at));
    const bool control =
        (code < 0x20 && code != '\t' && code != '\n' && code != '\r') || code == 0x7f;
    if (size == 0 || control) {
      builder.fail(where, "",
                   control ? fmt::format("a control character (0x{:02x})", code)
                           : fmt::format("a byte (0x{:02x}) that is not UTF-8", code),
                   "save the file as UTF-8 text");
    }
    where.column = text[at] == '\n' ? 1 : where.column + 1;
    where.line += text[at] == '\n';
    at += size;
  }
}

bool tab_indents(const std::string& text, int line) {
  std::istringstream lines(text);
  std::string one;
  for (int i = 0; i < line; ++i) {
    if (!std::getline(lines, one)) return false;
  }
  return one.substr(0, one.find_first_not_of(" \t")).find('\t') != std::string::npos;
}

}  // namespace

ConfigTree read_yaml(const std::string& document, const std::string& file_name,
                     const std::string& override_by) {
  // Places are counted from behind a byte order mark.
  const std::string text = document.starts_with("\xef\xbb\xbf") ? document.substr(3) : document;
  TreeBuilder builder(text, file_name, override_by);
  refuse_other_encodings(text, builder, override_by);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    // A second document is an error, so that the loop ends after two turns at most.
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    const ConfigPlace where = builder.place(error.mark);
    builder.fail(
        where, "", "malformed YAML: " + error.msg,
        tab_indents(text, where.line) ? "YAML forbids tabs in indentation; use spaces" : "");
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    builder.fail(builder.place(YAML::Mark()), "", fmt::format("malformed YAML: {}", error.what()));
  }
  return builder.take();
}

}  // namespace carillon::core
