#include "core/hash.hpp"

#include <openssl/evp.h>

#include <array>
#include <new>
#include <stdexcept>

#include "core/error.hpp"
#include "core/files.hpp"

namespace carillon::core {

struct Sha256::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  ~State() { EVP_MD_CTX_free(context); }
};

Sha256::Sha256() : state_(std::make_unique<State>()) {
  if (state_->context == nullptr) throw std::bad_alloc();
  if (EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr) != 1) {
    throw Error("SHA-256 is not available", "OpenSSL's libcrypto lacks its default provider");
  }
}

Sha256::~Sha256() = default;

Sha256& Sha256::add(std::span<const std::byte> bytes) {
  if (!state_) throw std::logic_error("Sha256::add after hex()");
  if (EVP_DigestUpdate(state_->context, bytes.data(), bytes.size()) != 1) {
    throw Error("SHA-256 failed");
  }
  return *this;
}

Sha256& Sha256::add(std::string_view text) {
  return add(std::as_bytes(std::span(text.data(), text.size())));
}

std::string Sha256::hex() {
  if (!state_) throw std::logic_error("Sha256::hex called twice");
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (EVP_DigestFinal_ex(state_->context, digest.data(), &size) != 1) {
    throw Error("SHA-256 failed");
  }
  state_.reset();
  constexpr char digits[] = "0123456789abcdef";
  std::string text;
  text.reserve(2 * size);
  for (unsigned int i = 0; i < size; ++i) {
    text += digits[digest[i] >> 4];
    text += digits[digest[i] & 15];
  }
  return text;
}

std::string sha256(std::string_view text) {
  return Sha256().add(text).hex();
}

std::string sha256_file(const std::filesystem::path& path) {
  Sha256 sum;
  read_blocks(path, [&](std::string_view block) { sum.add(block); });
  return sum.hex();
}

}  // namespace carillon::core
