#pragma once

#include <exception>
#include <string>

#include "core/error.hpp"

namespace carillon::core {

/// An exception as plain text, so that it can travel to another rank and into the journal.
struct Failure {
  /// Class of the error: ConfigError, InputError, LimitError, TimeError, MemoryError, SolverError,
  /// StorageError, FileError, or Error for all others. std::bad_alloc is a MemoryError.
  std::string kind;
  std::string message;
  std::string hint{};   ///< how to mend it; may be empty
  std::string stage{};  ///< part of the task that failed; may be empty
  std::string item{};   ///< what that part was busy with; may be empty
  /// The same again would fail again. Not so where it hung on the moment: what is in a journal then
  /// stands for its run alone.
  bool lasting = true;

  bool operator==(const Failure&) const = default;
};

/// The error of a task that knows which part of it failed.
class TaskError : public Error {
 public:
  explicit TaskError(Failure failure)
      : Error(failure.message, failure.hint), failure_(std::move(failure)) {}
  const Failure& failure() const { return failure_; }

 private:
  Failure failure_;
};

/// @param error  any exception, not null; what does not come from Error has kind Error
Failure describe(const std::exception_ptr& error);

/// Throws the error of that kind again; a kind that is not known is thrown as Error, and one
/// with a stage as TaskError.
[[noreturn]] void raise(const Failure& failure);

/// One line of JSON:
/// `{"kind":"SolverError","message":"...","hint":"...","stage":"...","item":"..."}`, the last three
/// only where there is one, and `"lasting":false` where it is not. Bytes that are not UTF-8 are
/// replaced.
std::string to_record(const Failure& failure);

/// @throws Error  the text is not such a record
Failure from_record(const std::string& record);

}  // namespace carillon::core
