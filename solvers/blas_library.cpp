#include "solvers/blas_library.hpp"

#include <dlfcn.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <memory>

extern "C" void dgemm_();

namespace carillon::solvers {
namespace {

struct CloseLibrary {
  void operator()(void* handle) const { dlclose(handle); }
};

}  // namespace

std::string blas_complaint() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<void*>(&dgemm_), &info) == 0 || info.dli_fname == nullptr) return {};
  // Asked of the library that products really go to, and those it needs: another BLAS may be
  // loaded beside it.
  const std::unique_ptr<void, CloseLibrary> library(
      dlopen(info.dli_fname, RTLD_LAZY | RTLD_NOLOAD));
  if (!library) return {};
  const auto has = [&library](const char* symbol) {
    return dlsym(library.get(), symbol) != nullptr;
  };
  // OpenBLAS, BLIS, MKL, ATLAS.
  constexpr std::array tuned = {"openblas_get_config", "bli_info_get_version_str",
                                "mkl_get_version", "ATL_buildinfo"};
  if (std::none_of(tuned.begin(), tuned.end(), has)) {
    return fmt::format(
        "{} looks like the reference BLAS, with which solves take many times longer; on Debian: "
        "apt-get install libopenblas0-serial",
        info.dli_fname);
  }
  const auto threads =
      reinterpret_cast<int (*)()>(dlsym(library.get(), "openblas_get_num_threads"));
  if (threads != nullptr && threads() > 1) {
    return fmt::format(
        "{} runs {} threads, which slow each other and other ranks down; set "
        "OPENBLAS_NUM_THREADS=1 and OMP_NUM_THREADS=1, or install libopenblas0-serial",
        info.dli_fname, threads());
  }
  return {};
}

}  // namespace carillon::solvers
