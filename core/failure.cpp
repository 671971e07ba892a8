#include "core/failure.hpp"

#include <new>
#include <nlohmann/json.hpp>

#include "core/storage_error.hpp"

namespace carillon::core {

namespace {

Failure of_kind(const char* kind, const Error& error) {
  return {kind, error.message(), error.hint(), "", ""};
}

}  // namespace

Failure describe(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const TaskError& e) {
    return e.failure();
  } catch (const ConfigError& e) {
    return of_kind("ConfigError", e);
  } catch (const InputError& e) {
    return of_kind("InputError", e);
  } catch (const LimitError& e) {
    return of_kind("LimitError", e);
  } catch (const TimeError& e) {
    return of_kind("TimeError", e);
  } catch (const MemoryError& e) {
    return of_kind("MemoryError", e);
  } catch (const SolverError& e) {
    return of_kind("SolverError", e);
  } catch (const StorageError& e) {
    return of_kind("StorageError", e);
  } catch (const FileError& e) {
    return of_kind("FileError", e);
  } catch (const Error& e) {
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
  if (failure.kind == "ConfigError") throw ConfigError(failure.message, failure.hint);
  if (failure.kind == "InputError") throw InputError(failure.message, failure.hint);
  if (failure.kind == "LimitError") throw LimitError(failure.message, failure.hint);
  if (failure.kind == "TimeError") throw TimeError(failure.message, failure.hint);
  if (failure.kind == "MemoryError") throw MemoryError(failure.message, failure.hint);
  if (failure.kind == "SolverError") throw SolverError(failure.message, failure.hint);
  if (failure.kind == "StorageError") throw StorageError(failure.message, failure.hint);
  if (failure.kind == "FileError") throw FileError(failure.message, failure.hint);
  throw Error(failure.message, failure.hint);
}

std::string to_record(const Failure& failure) {
  nlohmann::ordered_json record{{"kind", failure.kind}, {"message", failure.message}};
  if (!failure.hint.empty()) record["hint"] = failure.hint;
  if (!failure.stage.empty()) record["stage"] = failure.stage;
  if (!failure.item.empty()) record["item"] = failure.item;
  if (!failure.lasting) record["lasting"] = false;
  return record.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Failure from_record(const std::string& record) {
  try {
    const nlohmann::json json = nlohmann::json::parse(record);
    return {json.at("kind"),         json.at("message"),     json.value("hint", ""),
            json.value("stage", ""), json.value("item", ""), json.value("lasting", true)};
  } catch (const nlohmann::json::exception& e) {
    throw Error("not the record of a failure: " + record);
  }
}

}  // namespace carillon::core
