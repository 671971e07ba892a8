#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "core/error.hpp"

/// What libFuzzer calls with each input (llvm.org/docs/LibFuzzer.html).
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace carillon::fuzz {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A malformed input may end in an error for people, and in nothing else.
template <class Parse>
void expect_value_or_error(Parse&& parse) {
  try {
    parse();
  } catch (const core::Error& error) {
    if (error.message().empty()) std::abort();
  }
}

/// An input as a file, for parsers that open one. It lies in memory and goes with this object.
class InputFile {
 public:
  explicit InputFile(std::string_view bytes) : file_(memfd_create("input", 0)) {
    std::size_t written = 0;
    while (written < bytes.size()) {
      const ssize_t n = write(file_, bytes.data() + written, bytes.size() - written);
      if (n <= 0) std::abort();
      written += static_cast<std::size_t>(n);
    }
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile() { close(file_); }
  std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

}  // namespace carillon::fuzz
