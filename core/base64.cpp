#include "core/base64.hpp"

#include <openssl/evp.h>

#include <bit>

#include "core/error.hpp"

namespace carillon::core {

static_assert(std::endian::native == std::endian::little);

std::string base64(std::string_view bytes) {
  // Multiples of three, so that no block but the last is padded; its length is an int to OpenSSL.
  constexpr std::size_t block = 3 << 24;
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += block) {
    const std::string_view part = bytes.substr(at, block);
    const std::size_t begin = text.size();
    text.resize(begin + (part.size() + 2) / 3 * 4 + 1);  // OpenSSL ends it with a zero
    EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data() + begin),  // NOLINT
                    reinterpret_cast<const unsigned char*>(part.data()),    // NOLINT
                    static_cast<int>(part.size()));
    text.pop_back();
  }
  return text;
}

std::string from_base64(std::string_view text) {
  std::string plain;
  for (const char c : text)
    if (c != ' ' && c != '\n' && c != '\r' && c != '\t') plain += c;
  if (plain.size() % 4 != 0) throw InputError("a base64 text is cut off");
  const auto padding = static_cast<std::size_t>(plain.ends_with("==") ? 2 : plain.ends_with("="));
  // Multiples of four, as above.
  constexpr std::size_t block = 4 << 24;
  std::string bytes(plain.size() / 4 * 3, '\0');
  for (std::size_t at = 0; at < plain.size(); at += block) {
    const std::string_view part = std::string_view(plain).substr(at, block);
    const int size =
        EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data() + at / 4 * 3),  // NOLINT
                        reinterpret_cast<const unsigned char*>(part.data()),          // NOLINT
                        static_cast<int>(part.size()));
    if (size < 0) throw InputError("a base64 text has a character that is none of its own");
  }
  bytes.resize(bytes.size() - padding);
  return bytes;
}

}  // namespace carillon::core
