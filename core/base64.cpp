#include "core/base64.hpp"

#include <openssl/evp.h>

#include <bit>

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

}  // namespace carillon::core
