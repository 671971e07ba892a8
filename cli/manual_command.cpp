#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "core/revision.hpp"

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

std::string command_text(const Command& command) {
  std::string text = fmt::format(".SS {}\n{}\n", roff(command.name()), roff(command.summary()));
  for (const OptionText& option : command.options()) text += option_text(option);
  if (!command.footer().empty()) {
    text += fmt::format(".PP\n.nf\n{}\n.fi\n", roff(command.footer()));
  }
  return text;
}

std::string manual(const Program& program) {
  std::string text = fmt::format(
      ".TH CARILLON 1 \"\" \"carillon {}\" \"User Commands\"\n"
      ".SH NAME\ncarillon \\- datasets of struck objects: modes, sounds, voxels and pictures\n"
      ".SH SYNOPSIS\n\\fBcarillon\\fR [\\fIoptions\\fR] \\fIcommand\\fR [\\fIarguments\\fR]\n.br\n"
      "\\fBmpirun\\fR \\-n \\fIranks\\fR \\fBcarillon\\fR \\fIcommand\\fR [\\fIarguments\\fR]\n"
      ".SH DESCRIPTION\n{}\n.SH OPTIONS\n",
      core::version(), roff(program.common().summary()));
  for (const OptionText& option : program.common().options()) text += option_text(option);
  text += ".SH COMMANDS\n";
  for (const Command& command : program.commands()) text += command_text(command);
  text += fmt::format(".SH EXIT STATUS\n.nf\n{}\n.fi\n", roff(program.common().footer()));
  text +=
      ".SH ENVIRONMENT\n"
      ".TP\n\\fBCARILLON_CACHE\\fR\nfolder of meshes and modes that can be used again\n"
      ".TP\n\\fBCARILLON_PYTHON\\fR\nPython with matplotlib, for pictures beside documents\n"
      ".TP\n\\fBOMP_NUM_THREADS\\fR\n1: every rank computes on one thread\n";
  return text;
}

}  // namespace

void add_manual(Program& program, Context& context) {
  Command& command = program.add("manual", "this program's manual page", Needs::nothing);
  command.footer(
      "Examples:\n"
      "  carillon manual | man -l -\n"
      "  carillon manual > ~/.local/share/man/man1/carillon.1");
  command.does([&program, &context] {
    if (context.speaks()) fmt::print("{}", manual(program));
  });
}

}  // namespace carillon::cli
