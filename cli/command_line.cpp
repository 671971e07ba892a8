#include "cli/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <regex>
#include <sstream>

namespace carillon::cli {

namespace {

/// CLI11 writes the words of a closed set into the name of the option's type: `TEXT:{a,b}`.
std::vector<std::string> choices_in(const std::string& type) {
  const std::size_t begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return {};
  return CLI::detail::split(type.substr(begin + 1, end - begin - 1), ',');
}

OptionText text_of(const CLI::Option& option) {
  OptionText text;
  for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
  text.positional = text.names.empty();
  if (text.positional) text.names.push_back(option.get_name());
  text.description = option.get_description();
  text.choices = choices_in(option.get_type_name());
  text.takes_value = option.get_items_expected_min() > 0;
  return text;
}

}  // namespace

Option& Option::required(bool is) {
  option_->required(is);
  return *this;
}

Option& Option::description(const std::string& text) {
  option_->description(text);
  return *this;
}

Option& Option::show_default() {
  option_->capture_default_str();
  return *this;
}

Option& Option::show_default(const std::string& text) {
  option_->default_str(text);
  return *this;
}

template <class Number>
Option& Option::range(Number low, Number high) {
  option_->check(CLI::Range(low, high));
  return *this;
}

template Option& Option::range(int, int);
template Option& Option::range(std::size_t, std::size_t);
template Option& Option::range(double, double);

Option& Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return *this;
}

Option& Option::check(std::string (*complaint)(const std::string& text)) {
  option_->check(complaint);
  return *this;
}

Option& Option::needs(const Option& other) {
  option_->needs(other.option_);
  return *this;
}

Option& Option::delimiter(char between) {
  option_->delimiter(between);
  return *this;
}

Option& Option::one_value_each() {
  option_->allow_extra_args(false);
  return *this;
}

template <class Value>
Option Command::option(const std::string& names, Value& variable, const std::string& description) {
  return Option(*app_->add_option(names, variable, description));
}

template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, double&, const std::string&);
template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, std::int64_t&, const std::string&);
template Option Command::option(const std::string&, std::size_t&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, std::vector<int>&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::int64_t>&, const std::string&);
template Option Command::option(const std::string&, std::optional<std::string>&,
                                const std::string&);
template Option Command::option(const std::string&, std::optional<int>&, const std::string&);

Option Command::flag(const std::string& names, bool& variable, const std::string& description) {
  return Option(*app_->add_flag(names, variable, description));
}

Option Command::option_named(const std::string& name) {
  return Option(*app_->get_option(name));
}

void Command::remove(const std::string& name) {
  app_->remove_option(app_->get_option(name));
}

void Command::footer(const std::string& text) {
  app_->footer(text);
}

void Command::begin() const {
  if (beginning_) beginning_();
}

void Command::run() const {
  if (action_) action_();
}

const std::string& Command::name() const {
  return app_->get_name();
}

std::string Command::summary() const {
  return app_->get_description();
}

std::string Command::footer() const {
  return app_->get_footer();
}

bool Command::has(const std::string& option) const {
  return app_->get_option_no_throw(option) != nullptr;
}

std::string Command::in_options(const std::string& message) const {
  std::string text = message;
  for (const OptionText& option : options()) {
    for (const std::string& name : option.names) {
      if (!name.starts_with("--")) continue;
      std::string key = name.substr(2);
      std::replace(key.begin(), key.end(), '-', '_');
      // A value ends where the sentence goes on; a unit may follow it. A message that begins so
      // speaks of the thing itself.
      const std::regex setting(fmt::format(
          R"(([ (]){}: (?:([-+.0-9e]+) ?([A-Za-z]*)|(true|false|mm|cm|m|inch|um|km)\b))", key));
      text = std::regex_replace(text, setting,
                                fmt::format("$1{}{}", name, option.takes_value ? " $2$3$4" : ""));
      if (key.find('_') != std::string::npos)
        text = std::regex_replace(text, std::regex(fmt::format(R"(\b{}\b)", key)), name);
    }
  }
  return text;
}

std::vector<OptionText> Command::options() const {
  std::vector<OptionText> texts;
  const CLI::App& app = *app_;
  for (const CLI::Option* option : app.get_options()) texts.push_back(text_of(*option));
  return texts;
}

Program::Program(const std::string& name, const std::string& summary,
                 std::function<std::string()> version)
    : app_(std::make_unique<CLI::App>(summary)), common_(*app_, Needs::nothing) {
  app_->name(name);
  app_->set_version_flag("--version", std::move(version));
  app_->require_subcommand(1);
  app_->fallthrough();  // commands inherit it when they are added
}

Program::~Program() = default;

Command& Program::add(const std::string& name, const std::string& summary, Needs needs) {
  return commands_.emplace_back(*app_->add_subcommand(name, summary), needs);
}

std::optional<Reply> Program::parse(int argc, const char* const* argv) {
  try {
    app_->parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    std::ostringstream text;
    app_->exit(error, text, text);
    return Reply{text.str(), error.get_exit_code() != 0};
  }
}

const Command& Program::chosen() const {
  const std::string name = app_->get_subcommands().front()->get_name();
  return *std::find_if(commands_.begin(), commands_.end(),
                       [&](const Command& command) { return command.name() == name; });
}

}  // namespace carillon::cli
