#include "mpi/failure.hpp"

#include <new>
#include <nlohmann/json.hpp>

#include "core/storage_error.hpp"

namespace carillon::mpi {

namespace {

Failure of_kind(const char* kind, const core::Error& error) {
  return {kind, error.message(), error.hint(), "", ""};
}

}  // namespace

Failure describe(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const TaskError& e) {
    return e.failure();
  } catch (const core::ConfigError& e) {
    return of_kind("ConfigError", e);
  } catch (const core::InputError& e) {
    return of_kind("InputError", e);
  } catch (const core::LimitError& e) {
    return of_kind("LimitError", e);
  } catch (const core::TimeError& e) {
    return of_kind("TimeError", e);
  } catch (const core::MemoryError& e) {
    return of_kind("MemoryError", e);
  } catch (const core::SolverError& e) {
    return of_kind("SolverError", e);
  } catch (const core::StorageError& e) {
    return of_kind("StorageError", e);
  } catch (const core::FileError& e) {
    return of_kind("FileError", e);
  } catch (const core::Error& e) {
    return of_kind("Error", e);
  } catch (const std::bad_alloc&) {
    return {"MemoryError", "out of memory", ""};
  } catch (const std::exception& e) {
    return {"Error", e.what(), ""};
  } catch (...) {
    return {"Error", "an unknown exception", ""};
  }
}

void raise(const Failure& failure) {
  if (!failure.stage.empty()) throw TaskError(failure);
  if (failure.kind == "ConfigError") throw core::ConfigError(failure.message, failure.hint);
  if (failure.kind == "InputError") throw core::InputError(failure.message, failure.hint);
  if (failure.kind == "LimitError") throw core::LimitError(failure.message, failure.hint);
  if (failure.kind == "TimeError") throw core::TimeError(failure.message, failure.hint);
  if (failure.kind == "MemoryError") throw core::MemoryError(failure.message, failure.hint);
  if (failure.kind == "SolverError") throw core::SolverError(failure.message, failure.hint);
  if (failure.kind == "StorageError") throw core::StorageError(failure.message, failure.hint);
  if (failure.kind == "FileError") throw core::FileError(failure.message, failure.hint);
  throw core::Error(failure.message, failure.hint);
}

std::string to_record(const Failure& failure) {
  nlohmann::ordered_json record{{"kind", failure.kind}, {"message", failure.message}};
  if (!failure.hint.empty()) record["hint"] = failure.hint;
  if (!failure.stage.empty()) record["stage"] = failure.stage;
  if (!failure.item.empty()) record["item"] = failure.item;
  return record.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Failure from_record(const std::string& record) {
  try {
    const nlohmann::json json = nlohmann::json::parse(record);
    return {json.at("kind"), json.at("message"), json.value("hint", ""), json.value("stage", ""),
            json.value("item", "")};
  } catch (const nlohmann::json::exception& e) {
    throw core::Error("not the record of a failure: " + record);
  }
}

}  // namespace carillon::mpi
