#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

// The one door to CLI11, whose headers only command_line.cpp reads.
namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace carillon::cli {

/// What is started for a command before it runs.
enum class Needs {
  nothing,  ///< and its communicator is MPI_COMM_NULL, unless a launcher started the program
  ranks,    ///< MPI
  solver    ///< MPI, PETSc and SLEPc
};

/// One option of a command, as completion and manual know it.
struct OptionText {
  std::vector<std::string> names;  ///< with their dashes; of a positional its bare name
  std::string description;
  std::vector<std::string> choices;  ///< the words that it takes; empty: others
  bool positional = false;
  bool takes_value = false;
};

/// An option of a command that lives elsewhere; copies speak of the same one.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  Option& required(bool is = true);
  Option& description(const std::string& text);
  /// Help shows the value that the variable has now, or a text in its place.
  Option& show_default();
  Option& show_default(const std::string& text);
  /// The value lies between two others or is one of them. Defined for int, std::size_t and double,
  /// which is also the type that help names.
  template <class Number>
  Option& range(Number low, Number high);
  Option& one_of(const std::vector<std::string>& words);
  /// @param complaint  of a text; "": nothing is wrong with it
  Option& check(std::string (*complaint)(const std::string& text));
  /// Refused without the other one.
  Option& needs(const Option& other);
  /// One text is several values.
  Option& delimiter(char between);
  /// Each time it is given it takes one value; what follows is not its own.
  Option& one_value_each();

 private:
  CLI::Option* option_;
};

/// A command: its options, and what it does.
class Command {
 public:
  Command(CLI::App& app, Needs needs) : app_(&app), needs_(needs) {}

  /// An option or, where the name has no dash, a positional argument.
  /// @param names     "-o,--output"
  /// @param variable  is set by the command line, and outlives the program; defined for
  ///                  std::string, double, int, std::int64_t, std::size_t, std::vector of
  ///                  std::string, int and std::int64_t, std::optional of std::string and int
  template <class Value>
  Option option(const std::string& names, Value& variable, const std::string& description);
  /// An option without a value.
  Option flag(const std::string& names, bool& variable, const std::string& description);
  /// One that is there already.
  /// @param name  with its dashes
  Option option_named(const std::string& name);
  void remove(const std::string& name);
  /// What help ends with.
  void footer(const std::string& text);
  /// What it does once everything that it needs has been started.
  void does(std::function<void()> action) { action_ = std::move(action); }
  /// What it does before that, whatever it needs: another program may take this one's place.
  void begins_with(std::function<void()> action) { beginning_ = std::move(action); }

  Needs needs() const { return needs_; }
  void begin() const;
  void run() const;

  const std::string& name() const;
  std::string summary() const;
  std::string footer() const;
  bool has(const std::string& option) const;
  /// A message in the words of this command: keys of a configuration that are options here, as in
  /// `length: 6 mm` or `max_elements`, become `--length 6mm` and `--max-elements`.
  std::string in_options(const std::string& message) const;
  /// In the order of help.
  std::vector<OptionText> options() const;

 private:
  CLI::App* app_;
  Needs needs_;
  std::function<void()> beginning_, action_;
};

/// What a command line gets that runs no command.
struct Reply {
  std::string text;      ///< help or the version; of a refused one what is wrong with it
  std::string hint{};    ///< of a refused one
  bool refused = false;  ///< else it asked for help or the version
};

/// A program whose first argument, after options common to all, is a command.
class Program {
 public:
  /// @param version  text of --version, made when it is asked for
  Program(const std::string& name, const std::string& summary,
          std::function<std::string()> version);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Summary, footer and options of the program itself, which may stand after a command too.
  Command& common() { return common_; }
  const Command& common() const { return common_; }
  /// Adds a command, which lives as long as the program.
  Command& add(const std::string& name, const std::string& summary, Needs needs);
  /// In the order of help.
  const std::list<Command>& commands() const { return commands_; }

  /// Reads a command line and sets the variables of its options. Once.
  /// @return a reply where it runs no command
  std::optional<Reply> parse(int argc, const char* const* argv);
  /// The command that was asked for; after parse() without a reply.
  const Command& chosen() const;

 private:
  std::unique_ptr<CLI::App> app_;
  Command common_;
  std::list<Command> commands_;
};

}  // namespace carillon::cli
