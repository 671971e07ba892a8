#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace carillon::core {

/// A failure with a message for a person and, where it helps, a hint how to mend it.
/// `what()` holds both.
class Error : public std::runtime_error {
 public:
  explicit Error(std::string message, std::string hint = {})
      : std::runtime_error(hint.empty() ? message : message + "\n  hint: " + hint),
        message_(std::move(message)),
        hint_(std::move(hint)) {}

  const std::string& message() const { return message_; }
  const std::string& hint() const { return hint_; }

 private:
  std::string message_;
  std::string hint_;
};

/// The configuration is wrong; the message begins with `file:line:column:`.
struct ConfigError : Error {
  using Error::Error;
};
/// A mesh, a recording or a command-line value cannot be used.
struct InputError : Error {
  using Error::Error;
};
/// A numerical method did not reach its goal.
struct SolverError : Error {
  using Error::Error;
};
/// More than a limit that the user set would be needed; the message names it.
struct LimitError : SolverError {
  using SolverError::SolverError;
};
/// A file cannot be read or written.
struct FileError : Error {
  using Error::Error;
};

}  // namespace carillon::core
