#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace carillon::core {

/// SHA-256 of everything that was added, in order (OpenSSL's libcrypto).
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256& add(std::span<const std::byte> bytes);
  Sha256& add(std::string_view text);
  template <class T>
  requires std::is_trivially_copyable_v<T> Sha256& add(std::span<const T> values) {
    return add(std::as_bytes(values));
  }
  /// 64 hexadecimal digits. Ends the computation.
  std::string hex();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string sha256(std::string_view text);
/// A name for a text that nobody can find who lacks the secret: HMAC-SHA-256 (RFC 2104), 64
/// hexadecimal digits.
std::string hmac_sha256(std::string_view secret, std::string_view text);
/// A secret of 256 random bits, 64 hexadecimal digits (OpenSSL's generator).
/// @throws Error  the system has none
std::string make_secret();
/// @throws FileError  the file cannot be read
std::string sha256_file(const std::filesystem::path& path);

}  // namespace carillon::core
