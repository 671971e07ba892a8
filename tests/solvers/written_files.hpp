#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>

#include "core/temporary_folder.hpp"

namespace carillon::test {

/// Path of a new file in a folder that holds `bytes`.
inline std::string written(const core::TemporaryFolder& folder, const std::string& name,
                           std::string_view bytes) {
  const auto path = folder / name;
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path.string();
}

/// what() of the E that `run` throws; "" when it throws nothing, and a failed check when it throws
/// something else.
template <class E, class Run>
std::string message_of(Run run) {
  try {
    run();
  } catch (const E& error) {
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another error: " << error.what();
  }
  return "";
}

/// `bytes` with up to five changes: bytes flipped, cut out, doubled, replaced by telling words, or
/// the end cut off.
inline std::string damaged(std::string bytes, std::mt19937_64& random) {
  static const std::string telling[] = {"-1", "999999999999", "nan", "\n", " ", "\"", "0", "$End"};
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  for (std::size_t changes = 1 + below(5); changes > 0 && !bytes.empty(); --changes) {
    const std::size_t at = below(bytes.size());
    switch (below(9)) {
      case 0:
        bytes.resize(at);
        break;
      case 1:
      case 2:
        bytes.erase(at, 1 + below(20));
        break;
      case 3:
      case 4:
        bytes.insert(at, bytes.substr(at, 16));
        break;
      case 5:
      case 6:
        bytes.replace(at, 1, telling[below(std::size(telling))]);
        break;
      default:
        bytes[at] = static_cast<char>(below(256));
    }
  }
  return bytes;
}

}  // namespace carillon::test
