#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "solvers/families/families.hpp"
#include "synth/material/material.hpp"

namespace carillon::cli {

namespace {

/// A word within single quotes of a shell.
std::string quoted(std::string text) {
  for (std::size_t at = text.find('\''); at != std::string::npos; at = text.find('\'', at + 4)) {
    text.replace(at, 1, "'\\''");
  }
  return "'" + text + "'";
}

std::string materials() {
  std::vector<std::string> names;
  for (const synth::material::Material& material : synth::material::preset_materials())
    names.push_back(material.name);
  return fmt::format("{}", fmt::join(names, " "));
}

std::string shapes() {
  std::vector<std::string> names;
  for (const solvers::families::Family& family : solvers::families::families())
    names.emplace_back(family.name);
  return fmt::format("{}", fmt::join(names, " "));
}

bool simulations_shape(const Command& command) {
  return command.has("--element-size");
}

/// The names of all options, and a case for each one that takes certain words.
struct BashWords {
  std::vector<std::string> names;
  std::string cases;
};

BashWords bash_words(const Command& command) {
  BashWords words;
  for (const OptionText& option : command.options()) {
    if (option.positional) continue;
    words.names.insert(words.names.end(), option.names.begin(), option.names.end());
    const bool is_material =
        std::find(option.names.begin(), option.names.end(), "--material") != option.names.end();
    const std::string values =
        is_material ? materials() : fmt::format("{}", fmt::join(option.choices, " "));
    if (values.empty()) continue;
    words.cases +=
        fmt::format("        {}) words={} ;;\n", fmt::join(option.names, "|"), quoted(values));
  }
  return words;
}

std::string bash_script(const Program& program) {
  std::vector<std::string> names;
  std::string cases;
  const BashWords common = bash_words(program.common());
  for (const Command& command : program.commands()) {
    names.push_back(command.name());
    const BashWords words = bash_words(command);
    std::vector<std::string> options = words.names;
    options.insert(options.end(), common.names.begin(), common.names.end());
    std::string others;
    for (const OptionText& option : command.options()) {
      if (option.positional && !option.choices.empty()) {
        others = fmt::format("{}", fmt::join(option.choices, " "));
      }
    }
    if (simulations_shape(command)) others = shapes();
    cases += fmt::format(
        "    {})\n      options={}\n      others={}\n      case $previous in\n{}{}      esac\n     "
        " ;;\n",
        command.name(), quoted(fmt::format("{}", fmt::join(options, " "))), quoted(others),
        words.cases, "        *) ;;\n");
  }
  return fmt::format(
      R"(# Completion of carillon's commands, options and names; made by `carillon completion bash`.
_carillon() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}}
  local command='' options={} others='' words='' word
  for word in "${{COMP_WORDS[@]:1:$COMP_CWORD-1}}"; do
    case $word in
      {}) command=$word; break ;;
    esac
  done
  case $command in
    '') others={} ;;
{}  esac
  if [ -n "$words" ]; then
    COMPREPLY=($(compgen -W "$words" -- "$current"))
  elif [[ $current == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$current"))
  elif [ -z "$command" ]; then
    COMPREPLY=($(compgen -W "$others" -- "$current"))
  else
    COMPREPLY=($(compgen -W "$others" -- "$current") $(compgen -f -- "$current"))
  fi
}}
complete -o filenames -F _carillon carillon
)",
      quoted(fmt::format("{}", fmt::join(common.names, " "))), fmt::join(names, "|"),
      quoted(fmt::format("{}", fmt::join(names, " "))), cases);
}

std::string fish_option(const OptionText& option, const std::string& condition) {
  if (option.positional) return {};
  std::string line = "complete -c carillon" + condition;
  for (const std::string& name : option.names) {
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  if (option.takes_value) line += " -r";
  if (!option.choices.empty()) {
    line += " -f -a " + quoted(fmt::format("{}", fmt::join(option.choices, " ")));
  } else if (std::find(option.names.begin(), option.names.end(), "--material") !=
             option.names.end()) {
    line += " -f -a " + quoted(materials());
  }
  return line + " -d " + quoted(option.description) + "\n";
}

std::string fish_script(const Program& program) {
  std::string script =
      "# Completion of carillon's commands, options and names; made by `carillon completion "
      "fish`.\n";
  for (const OptionText& option : program.common().options()) script += fish_option(option, "");
  for (const Command& command : program.commands()) {
    const std::string condition = " -n '__fish_seen_subcommand_from " + command.name() + "'";
    script += fmt::format("complete -c carillon -n __fish_use_subcommand -f -a {} -d {}\n",
                          command.name(), quoted(command.summary()));
    for (const OptionText& option : command.options()) {
      if (option.positional && !option.choices.empty()) {
        script += fmt::format("complete -c carillon{} -f -a {}\n", condition,
                              quoted(fmt::format("{}", fmt::join(option.choices, " "))));
      }
      script += fish_option(option, condition);
    }
    if (simulations_shape(command)) {
      script += fmt::format("complete -c carillon{} -a {}\n", condition, quoted(shapes()));
    }
  }
  return script;
}

}  // namespace

void add_completion(Program& program, Context& context) {
  Command& command =
      program.add("completion", "a script that completes commands in a shell", Needs::nothing);
  auto shell = std::make_shared<std::string>();
  command.option("shell", *shell, "bash, zsh or fish").required().one_of({"bash", "zsh", "fish"});
  command.footer(
      "Examples:\n"
      "  carillon completion bash > ~/.local/share/bash-completion/completions/carillon\n"
      "  carillon completion zsh >> ~/.zshrc\n"
      "  carillon completion fish > ~/.config/fish/completions/carillon.fish");
  command.does([&program, &context, shell] {
    if (!context.speaks()) return;
    // zsh reads bash's scripts, as long as no length of a slice begins with a letter.
    if (*shell == "zsh") fmt::print("autoload -U +X bashcompinit && bashcompinit\n");
    fmt::print("{}", *shell == "fish" ? fish_script(program) : bash_script(program));
  });
}

}  // namespace carillon::cli
