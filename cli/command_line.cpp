#include "cli/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <regex>
#include <sstream>
#include <type_traits>
#include <utility>

#include "core/did_you_mean.hpp"

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

/// The command that a command line names, or the program itself.
CLI::App& asked_of(CLI::App& program) {
  const std::vector<CLI::App*> commands = program.get_subcommands();
  return commands.empty() ? program : *commands.front();
}

/// The name under which help speaks of a command.
std::string full_name(const CLI::App& program, const CLI::App& command) {
  return &program == &command ? program.get_name() : program.get_name() + " " + command.get_name();
}

/// The first word of a command line that nothing takes: an option that there is not before what
/// stands as its value. "": there is none.
std::string left_over(const CLI::App& program, int argc, const char* const* argv) {
  const std::vector<std::string> words = program.remaining(true);
  std::string first;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (std::find(words.begin(), words.end(), word) == words.end()) continue;
    if (word.starts_with('-') && word != "-") return word;
    if (first.empty()) first = word;
  }
  return first;
}

/// What is wrong with a word that nothing takes.
std::string complaint_about(const std::string& word, CLI::App& program) {
  CLI::App& command = asked_of(program);
  if (word.starts_with('-') && word != "-") {
    const std::string name = word.substr(0, word.find('='));
    std::vector<std::string> known;
    for (const CLI::App* app : {&command, &program}) {
      for (const CLI::Option* option : std::as_const(*app).get_options()) {
        for (const std::string& known_name : text_of(*option).names) {
          if (known_name.starts_with('-')) known.push_back(known_name);
        }
      }
    }
    return fmt::format("{}: {} has no such option{}", name, full_name(program, command),
                       core::did_you_mean(name, known));
  }
  if (&command != &program) {
    return fmt::format("\"{}\": one word more than {} takes", word, full_name(program, command));
  }
  std::vector<std::string> known;
  for (const CLI::App* one : program.get_subcommands({})) known.push_back(one->get_name());
  return fmt::format("\"{}\" is no command{}", word, core::did_you_mean(word, known));
}

/// The option that CLI11's message begins with, or null.
const CLI::Option* option_of(const std::string& message, CLI::App& program) {
  const std::string name = message.substr(0, message.find_first_of(": "));
  for (CLI::App* app : {&asked_of(program), &program}) {
    if (const CLI::Option* option = app->get_option_no_throw(name)) return option;
  }
  return nullptr;
}

std::string number_wanted(const CLI::Option& option) {
  const std::string type = option.get_type_name().substr(0, option.get_type_name().find(':'));
  return type == "UINT"  ? "a whole number from 0 on"
         : type == "INT" ? "a whole number"
                         : "a number";
}

/// CLI11's complaint in a user's words.
std::string complaint_of(const CLI::ParseError& error, CLI::App& program) {
  const std::string message = error.what();
  const CLI::Option* option = option_of(message, program);
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr && option != nullptr) {
    const auto most = static_cast<std::size_t>(std::max(0, option->get_items_expected_max()));
    return option->count() > most ? fmt::format("{} is given {} times; once is enough",
                                                option->get_name(), option->count())
                                  : fmt::format("{}: its value is missing", option->get_name());
  }
  if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr) {
    static const std::regex form("Could not convert: (.+) = (.*)");
    std::smatch parts;
    if (std::regex_match(message, parts, form)) {
      const CLI::Option* converted = option_of(parts[1].str(), program);
      return fmt::format("{}: {} is wanted, not \"{}\"", parts[1].str(),
                         converted != nullptr ? number_wanted(*converted) : "a number",
                         parts[2].str());
    }
  }
  return message;
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
  const auto complain = [words](const std::string& word) -> std::string {
    if (std::find(words.begin(), words.end(), word) != words.end()) return "";
    return fmt::format("\"{}\" is none of {}{}", word, fmt::join(words, ", "),
                       core::did_you_mean(word, words));
  };
  option_->check(CLI::Validator(complain, fmt::format("{{{}}}", fmt::join(words, ","))));
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
  CLI::Option* option = app_->add_option(names, variable, description);
  if constexpr (std::is_unsigned_v<Value>) {
    // CLI11 reads -1 as the largest number that there is.
    option->check([](const std::string& text) {
      return std::string(text.starts_with('-') ? "a whole number from 0 on is wanted, not " + text
                                               : "");
    });
  }
  return Option(*option);
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
      // speaks of the thing itself, and one that lists units of none.
      const std::regex setting(fmt::format(
          R"(([ (]){}: (?:([-+.0-9e]+) ?([A-Za-z]*)|(true|false|mm|cm|m|inch|um|km)\b(?!, (?:cm|m)\b)))",
          key));
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
    const bool refused = error.get_exit_code() != 0;
    const std::string word = left_over(*app_, argc, argv);
    const CLI::App& command = asked_of(*app_);
    // Help of a command that there is not would be taken for an answer.
    if (refused || (&command == app_.get() && !word.empty())) {
      const bool named = !app_->get_subcommands().empty();
      return Reply{!word.empty() ? complaint_about(word, *app_)
                   : named       ? complaint_of(error, *app_)
                                 : "a command is missing",
                   named ? fmt::format("{} --help says what it takes", full_name(*app_, command))
                         : fmt::format("{} --help lists the commands", app_->get_name()),
                   true};
    }
    std::ostringstream text;
    app_->exit(error, text, text);
    return Reply{text.str(), "", false};
  }
}

const Command& Program::chosen() const {
  const std::string name = app_->get_subcommands().front()->get_name();
  return *std::find_if(commands_.begin(), commands_.end(),
                       [&](const Command& command) { return command.name() == name; });
}

}  // namespace carillon::cli
