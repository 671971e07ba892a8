#include "solvers/libraries/environment.hpp"

#include <fmt/core.h>
#include <mpi.h>
#include <slepcsys.h>
#include <spdlog/spdlog.h>

#include <cctype>
#include <exception>
#include <sstream>
#include <utility>

#include "core/error.hpp"
#include "solvers/libraries/detail/blas_library.hpp"

namespace carillon::solvers::libraries {
namespace {

/// What PETSc said about the error that is on its way up. PETSc itself is one per process and
/// used from one thread, so this is too.
std::string& pending_message() {
  static std::string message;
  return message;
}

/// What a function threw that PETSc had called.
std::exception_ptr& pending_exception() {
  static std::exception_ptr exception;
  return exception;
}

/// Options without those that only print.
std::string without_prints(const std::string& options) {
  std::istringstream words(options);
  std::string out;
  bool is_said = true;
  for (std::string word; words >> word;) {
    // A value belongs to the option before it; a negative number is one.
    const bool is_option = word.size() > 1 && word[0] == '-' && std::isalpha(word[1]) != 0;
    if (is_option) {
      is_said = word.find("monitor") == std::string::npos &&
                word.find("view") == std::string::npos && word.find("log") == std::string::npos;
    }
    if (is_said) out += (out.empty() ? "" : " ") + word;
  }
  return out;
}

std::string& options_at_start() {
  static std::string options;
  return options;
}

PetscErrorCode collect(MPI_Comm, int, const char* function, const char*, PetscErrorCode code,
                       PetscErrorType type, const char* message, void*) {
  if (type == PETSC_ERROR_INITIAL) {
    pending_message() = fmt::format("{} (in {})", message ? message : "", function ? function : "");
  }
  return code;
}

}  // namespace

SolverEnvironment::SolverEnvironment() {
  int count = 3;
  static char program[] = "carillon", no_file[] = "-skip_petscrc",
              no_signals[] = "-no_signal_handler";
  static char* arguments[] = {program, no_file, no_signals, nullptr};
  char** pointer = arguments;
  check(SlepcInitialize(&count, &pointer, nullptr, nullptr));
  check(PetscPushErrorHandler(collect, nullptr));
  // PETSc reads them on rank 0 and tells the others.
  char* options = nullptr;
  check(PetscOptionsGetAll(nullptr, &options));
  options_at_start() = without_prints(options);
  check(PetscFree(options));
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (const auto complaint = blas_complaint(); rank == 0 && !complaint.empty()) {
    spdlog::warn("{}", complaint);
  }
}

SolverEnvironment::~SolverEnvironment() {
  PetscPopErrorHandler();
  SlepcFinalize();
}

void check(int code) {
  if (code == 0) return;
  if (auto exception = std::exchange(pending_exception(), nullptr)) {
    pending_message().clear();
    std::rethrow_exception(exception);
  }
  std::string text = std::move(pending_message());
  pending_message().clear();
  if (text.empty()) {
    const char* general = nullptr;
    PetscErrorMessage(static_cast<PetscErrorCode>(code), &general, nullptr);
    text = fmt::format("error {}{}{}", code, general ? ": " : "", general ? general : "");
  }
  if (code == PETSC_ERR_MEM) throw core::MemoryError("out of memory: PETSc: " + text);
  throw core::SolverError("PETSc: " + text);
}

int keep_exception() {
  pending_exception() = std::current_exception();
  return PetscError(PETSC_COMM_SELF, __LINE__, "guarded", __FILE__, PETSC_ERR_LIB,
                    PETSC_ERROR_INITIAL, "a function that PETSc called failed");
}

const std::string& solver_options() {
  return options_at_start();
}

ScopedOptions::ScopedOptions() {
  static long made = 0;
  prefix_ = fmt::format("carillon_{}_", ++made);
}

ScopedOptions::~ScopedOptions() {
  std::istringstream names(names_);
  for (std::string name; names >> name;) PetscOptionsClearValue(nullptr, name.c_str());
}

void ScopedOptions::set(const std::string& name, const std::string& value) {
  const std::string full = "-" + prefix_ + name;
  check(PetscOptionsSetValue(nullptr, full.c_str(), value.c_str()));
  names_ += full + " ";
}

}  // namespace carillon::solvers::libraries
