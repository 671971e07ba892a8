#include "core/detail/config_impl.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "core/detail/renamed_keys.hpp"
#include "core/error.hpp"
#include "core/quantity_list.hpp"

namespace carillon::core {

using Kind = ConfigTree::Kind;

std::string wanted_text(Dimension dimension) {
  if (dimension == Dimension::none) return "a number";
  return fmt::format("a value in {}", unit_name(dimension));
}

std::string ConfigNode::Impl::path_of(const std::string& key) const {
  if (key.empty()) return path;
  return path.empty() ? key : path + "." + key;
}

const ConfigEntry* ConfigNode::Impl::entry(const std::string& key) const {
  return tree != nullptr ? tree->find(key) : nullptr;
}

std::vector<std::string> ConfigNode::Impl::names() const {
  std::vector<std::string> keys;
  if (tree != nullptr) {
    for (const ConfigEntry& one : tree->entries) keys.push_back(one.key);
  }
  return keys;
}

const ConfigNode::Impl::Asked* ConfigNode::Impl::find_asked(const std::string& key) const {
  const auto found =
      std::find_if(asked.begin(), asked.end(), [&](const Asked& one) { return one.key == key; });
  return found == asked.end() ? nullptr : &*found;
}

ConfigNode::Impl::Asked* ConfigNode::Impl::find_asked(const std::string& key) {
  return const_cast<Asked*>(std::as_const(*this).find_asked(key));
}

void ConfigNode::Impl::remember(const std::string& key, Answer answer) {
  if (Asked* before = find_asked(key)) {
    if (!std::holds_alternative<Existence>(answer)) before->answer = std::move(answer);
  } else {
    asked.push_back({key, std::move(answer)});
  }
}

namespace {

thread_local HearAsk hear_ask;

}  // namespace

ConfigRecord::ConfigRecord(HearAsk hear) {
  hear_ask = std::move(hear);
}

ConfigRecord::~ConfigRecord() {
  hear_ask = nullptr;
}

void ConfigNode::Impl::answer(const std::string& key, Answer answer, const ConfigAsk& ask) {
  if (hear_ask) {
    std::vector<std::string> whole = steps;
    if (!key.empty()) whole.push_back(key);
    const auto* text = std::get_if<ConfigText>(&answer);
    hear_ask(document->file_name, whole, ask,
             text != nullptr && entry(key) == nullptr ? &text->value : nullptr);
  }
  if (!key.empty()) remember(key, std::move(answer));
}

double ConfigNode::Impl::quantity(const std::string& key, std::optional<double> fallback,
                                  ConfigAsk ask) {
  ask.kind = "quantity";
  ask.optional = fallback.has_value();
  const ConfigTree* found = value(key, wanted_text(ask.dimension), ask.optional);
  const double is = found != nullptr ? number(*found, key, ask.dimension) : *fallback;
  answer(key, yaml_quantity(is, ask.dimension), ask);
  return is;
}

void ConfigNode::Impl::refuse(const ConfigPlace& where, const std::string& full_path,
                              const std::string& message, const std::string& hint) const {
  const std::string start = where.text(document->file_name) + ": ";
  throw ConfigError(start + (full_path.empty() ? "" : full_path + ": ") + message, hint);
}

void ConfigNode::Impl::refuse_value(const ConfigTree& value, const std::string& key,
                                    const std::string& message, const std::string& hint) const {
  refuse(value.place, path_of(key), message, hint);
}

void ConfigNode::Impl::refuse_missing(const std::string& key, const std::string& wanted) const {
  std::vector<std::string> others = names();
  std::erase_if(others, [&](const std::string& name) { return find_asked(name) != nullptr; });
  std::string hint;
  const auto renamed = std::find_if(others.begin(), others.end(), [&](const std::string& name) {
    return renamed_key(path_of(name), {key}) == key;
  });
  if (renamed != others.end()) {
    hint = fmt::format("\"{}\" ({}) is now \"{}\"", *renamed,
                       entry(*renamed)->key_place.text(document->file_name), key);
  } else if (const std::string near = nearest_name(key, others); !near.empty()) {
    hint = fmt::format("is \"{}\" ({}) meant for it?", near,
                       entry(near)->key_place.text(document->file_name));
  }
  refuse(place, path_of(key), fmt::format("missing; {} is wanted", wanted), hint);
}

void ConfigNode::Impl::refuse_unknown_keys() const {
  std::vector<std::string> known;
  for (const Asked& one : asked) known.push_back(one.key);
  for (const std::string& key : names()) {
    if (std::find(left_alone.begin(), left_alone.end(), key) != left_alone.end()) continue;
    const Asked* one = find_asked(key);
    const ConfigPlace& where = entry(key)->key_place;
    if (one != nullptr && std::holds_alternative<Existence>(one->answer)) {
      refuse(where, path_of(key), "has no effect beside the other keys", "remove it");
    }
    if (one != nullptr) continue;
    if (const std::string now = renamed_key(path_of(key), known); !now.empty()) {
      refuse(where, path_of(key), fmt::format("is now \"{}\"", path_of(now)));
    }
    if (const std::string near = nearest_name(key, known); !near.empty()) {
      refuse(where, path_of(key), fmt::format("unknown key; did you mean \"{}\"?", near));
    }
    refuse(where, path_of(key), "unknown key",
           known.empty() ? "no key is known here"
                         : fmt::format("known keys: {}", fmt::join(known, ", ")));
  }
  for (const Asked& one : asked) {
    if (const auto* child = std::get_if<Pointer>(&one.answer)) (*child)->refuse_unknown_keys();
    if (const auto* list = std::get_if<std::vector<Pointer>>(&one.answer)) {
      for (const Pointer& item : *list) item->refuse_unknown_keys();
    }
  }
}

const ConfigTree* ConfigNode::Impl::value(const std::string& key, const std::string& wanted,
                                          bool optional) const {
  const ConfigEntry* found = entry(key);
  if (found == nullptr) {
    if (!optional) refuse_missing(key, wanted);
    return nullptr;
  }
  if (found->value.kind == Kind::nothing) {
    const bool set = !found->value.place.override_by.empty();
    refuse(set ? found->value.place : found->key_place, path_of(key),
           fmt::format("has no value; {} is wanted", wanted),
           optional ? "leave the key out for its default" : "");
  }
  return &found->value;
}

const std::string& ConfigNode::Impl::scalar(const ConfigTree& value, const std::string& key,
                                            const std::string& wanted) const {
  if (value.kind == Kind::scalar) return value.scalar;
  const char* what = value.kind == Kind::list      ? "a list"
                     : value.kind == Kind::mapping ? "a mapping"
                                                   : "nothing";
  refuse_value(value, key, fmt::format("{} is wanted, not {}", wanted, what));
}

double ConfigNode::Impl::number(const ConfigTree& value, const std::string& key,
                                Dimension dimension) const {
  const std::string& text = scalar(value, key, wanted_text(dimension));
  try {
    return parse_quantity(text, dimension);
  } catch (const InputError& error) {
    refuse_value(value, key, error.message(), error.hint());
  }
}

std::vector<ConfigTree> ConfigNode::Impl::with_own_units(const ConfigTree& list,
                                                         const std::string& key) const {
  std::vector<ConfigTree> items = list.items;
  // A list in the list, the range of one element, ends with a unit of its own or with none.
  std::vector<ConfigTree*> scalars;
  for (ConfigTree& item : items) {
    if (item.kind == Kind::list) item.items = with_own_units(item, key);
    if (item.kind == Kind::list) {
      for (ConfigTree& end : item.items) scalars.push_back(&end);
    } else {
      scalars.push_back(&item);
    }
  }
  std::vector<std::string> texts;
  for (const ConfigTree* one : scalars) {
    if (one->kind != Kind::scalar) return items;  // which is told where it is read
    texts.push_back(one->scalar);
  }
  try {
    texts = core::with_own_units(std::move(texts));
  } catch (const InputError& error) {
    refuse_value(list, key, error.message(), error.hint());
  }
  for (std::size_t i = 0; i < scalars.size(); ++i) scalars[i]->scalar = texts[i];
  return items;
}

std::vector<double> ConfigNode::Impl::numbers(const ConfigTree& list, const std::string& key,
                                              Dimension dimension) const {
  const std::vector<ConfigTree> items = with_own_units(list, key);
  std::vector<double> values;
  for (std::size_t i = 0; i < items.size(); ++i) {
    values.push_back(number(items[i], fmt::format("{}[{}]", key, i), dimension));
  }
  return values;
}

ConfigNode::Impl::Pointer ConfigNode::Impl::below(const ConfigTree* value, const ConfigPlace& where,
                                                  std::string name,
                                                  const std::vector<std::string>& further) const {
  auto one = std::make_shared<Impl>();
  one->document = document;
  one->tree = value;
  one->place = where;
  one->path = std::move(name);
  one->steps = steps;
  one->steps.insert(one->steps.end(), further.begin(), further.end());
  return one;
}

std::vector<std::string> ConfigNode::Impl::lines() const {
  std::vector<std::string> all;
  const auto append = [&](const std::vector<std::string>& inner, const std::string& first,
                          const std::string& rest) {
    for (std::size_t i = 0; i < inner.size(); ++i) {
      all.push_back((i == 0 ? first : rest) + inner[i]);
    }
  };
  for (const Asked& one : asked) {
    const std::string key = yaml_text(one.key) + ":";
    if (const auto* text = std::get_if<ConfigText>(&one.answer)) {
      const std::string unit = text->comment.empty() ? "" : "  # " + text->comment;
      all.push_back(fmt::format("{} {}{}", key, text->value, unit));
    } else if (const auto* child = std::get_if<Pointer>(&one.answer)) {
      const auto inner = (*child)->lines();
      all.push_back(inner.empty() ? key + " {}" : key);
      append(inner, "  ", "  ");
    } else if (const auto* list = std::get_if<std::vector<Pointer>>(&one.answer)) {
      all.push_back(list->empty() ? key + " []" : key);
      for (const Pointer& item : *list) {
        const auto inner = item->lines();
        append(inner.empty() ? std::vector<std::string>{"{}"} : inner, "  - ", "    ");
      }
    }
  }
  return all;
}

}  // namespace carillon::core
