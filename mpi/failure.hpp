#pragma once

#include <exception>
#include <string>

namespace carillon::mpi {

/// An exception as plain text, so that it can travel to another rank and into the journal.
struct Failure {
  /// Class of the error: ConfigError, InputError, LimitError, SolverError, StorageError, FileError,
  /// or Error for all others.
  std::string kind;
  std::string message;
  std::string hint;  ///< how to mend it; may be empty

  bool operator==(const Failure&) const = default;
};

/// @param error  any exception, not null; what does not come from core::Error has kind Error
Failure describe(const std::exception_ptr& error);

/// Throws the error of that kind again; a kind that is not known is thrown as core::Error.
[[noreturn]] void raise(const Failure& failure);

/// One line of JSON: `{"kind":"SolverError","message":"...","hint":"..."}`, the hint only where
/// there is one. Bytes that are not UTF-8 are replaced.
std::string to_record(const Failure& failure);

/// @throws core::Error  the text is not such a record
Failure from_record(const std::string& record);

}  // namespace carillon::mpi
