#include "solvers/libraries/detail/blas_library.hpp"

#include <dlfcn.h>
#include <fmt/core.h>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>

namespace carillon::solvers::libraries {
namespace {

struct CloseLibrary {
  void operator()(void* handle) const { dlclose(handle); }
};

/// The library that products really go to, and those it needs: another BLAS may be loaded beside
/// it.
struct Blas {
  std::string path;  ///< empty where it cannot be told
  std::unique_ptr<void, CloseLibrary> library;

  Blas() {
    Dl_info info{};
    if (dladdr(reinterpret_cast<void*>(&dgemm_), &info) == 0 || info.dli_fname == nullptr) return;
    path = info.dli_fname;
    library.reset(dlopen(info.dli_fname, RTLD_LAZY | RTLD_NOLOAD));
  }
};

}  // namespace

std::string blas_version() {
  const Blas blas;
  if (!blas.library) return "unknown";
  if (auto* const config = dlsym(blas.library.get(), "openblas_get_config")) {
    // "OpenBLAS 0.3.21 NO_LAPACKE DYNAMIC_ARCH ... Zen SINGLE_THREADED"
    const std::string text = reinterpret_cast<const char* (*)()>(config)();
    return text.substr(0, text.find(' ', text.find(' ') + 1));
  }
  if (auto* const version = dlsym(blas.library.get(), "bli_info_get_version_str")) {
    return fmt::format("BLIS {}", reinterpret_cast<const char* (*)()>(version)());
  }
  // Debian names a library's file by its version.
  return std::filesystem::weakly_canonical(blas.path).filename().string();
}

std::string blas_complaint() {
  const Blas blas;
  const auto& [path, library] = blas;
  if (!library) return {};
  const auto has = [handle = library.get()](const char* symbol) {
    return dlsym(handle, symbol) != nullptr;
  };
  // OpenBLAS, BLIS, MKL, ATLAS.
  constexpr std::array tuned = {"openblas_get_config", "bli_info_get_version_str",
                                "mkl_get_version", "ATL_buildinfo"};
  if (std::none_of(tuned.begin(), tuned.end(), has)) {
    return fmt::format(
        "{} looks like the reference BLAS, with which solves take many times longer; on Debian: "
        "apt-get install libopenblas0-serial",
        path);
  }
  const auto threads =
      reinterpret_cast<int (*)()>(dlsym(library.get(), "openblas_get_num_threads"));
  if (threads != nullptr && threads() > 1) {
    return fmt::format(
        "{} runs {} threads, which slow each other and other ranks down; set "
        "OPENBLAS_NUM_THREADS=1 and OMP_NUM_THREADS=1, or install libopenblas0-serial",
        path, threads());
  }
  return {};
}

}  // namespace carillon::solvers::libraries
