#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>

#include "cli/context.hpp"
#include "cli/reference/options.hpp"

namespace carillon::cli {

namespace {

/// Text as roff shows it: no line begins a request, no sign has a second meaning.
std::string roff(const std::string& text) {
  std::string safe;
  for (const char sign : text) {
    if ((sign == '.' || sign == '\'') && (safe.empty() || safe.back() == '\n')) safe += "\\&";
    if (sign == '\\') {
      safe += "\\e";
    } else if (sign == '-') {
      safe += "\\-";
    } else {
      safe += sign;
    }
  }
  return safe;
}

std::string option_text(const OptionText& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.names) names.push_back("\\fB" + roff(name) + "\\fR");
  std::string value;
  if (!option.choices.empty()) {
    value = " " + roff(fmt::format("{}", fmt::join(option.choices, "|")));
  } else if (option.takes_value && !option.positional) {
    value = " \\fIvalue\\fR";
  }
  return fmt::format(".TP\n{}{}\n{}\n", fmt::join(names, ", "), value, roff(option.description));
}

std::string command_text(const CLI::App& command) {
  std::string text =
      fmt::format(".SS {}\n{}\n", roff(command.get_name()), roff(command.get_description()));
  for (const OptionText& option : options_of(command)) text += option_text(option);
  if (!command.get_footer().empty()) {
    text += fmt::format(".PP\n.nf\n{}\n.fi\n", roff(command.get_footer()));
  }
  return text;
}

std::string manual(const CLI::App& program) {
  std::string text = fmt::format(
      ".TH CARILLON 1 \"\" \"carillon {}\" \"User Commands\"\n"
      ".SH NAME\ncarillon \\- datasets of struck objects: modes, sounds, voxels and pictures\n"
      ".SH SYNOPSIS\n\\fBcarillon\\fR [\\fIoptions\\fR] \\fIcommand\\fR [\\fIarguments\\fR]\n.br\n"
      "\\fBmpirun\\fR \\-n \\fIranks\\fR \\fBcarillon\\fR \\fIcommand\\fR [\\fIarguments\\fR]\n"
      ".SH DESCRIPTION\n{}\n.SH OPTIONS\n",
      CARILLON_VERSION, roff(program.get_description()));
  for (const OptionText& option : options_of(program)) text += option_text(option);
  text += ".SH COMMANDS\n";
  for (const CLI::App* command : commands_of(program)) text += command_text(*command);
  text += fmt::format(".SH EXIT STATUS\n.nf\n{}\n.fi\n", roff(program.get_footer()));
  text +=
      ".SH ENVIRONMENT\n"
      ".TP\n\\fBCARILLON_CACHE\\fR\nfolder of meshes and modes that can be used again\n"
      ".TP\n\\fBCARILLON_PYTHON\\fR\nPython with matplotlib, for pictures beside documents\n"
      ".TP\n\\fBOMP_NUM_THREADS\\fR\n1: every rank computes on one thread\n";
  return text;
}

}  // namespace

void add_manual(CLI::App& program, Context& context) {
  CLI::App* command = program.add_subcommand("manual", "this program's manual page");
  command->footer(
      "Examples:\n"
      "  carillon manual | man -l -\n"
      "  carillon manual > ~/.local/share/man/man1/carillon.1");
  command->callback([&program, &context] {
    if (context.speaks()) fmt::print("{}", manual(program));
  });
}

}  // namespace carillon::cli
