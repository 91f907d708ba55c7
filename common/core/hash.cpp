#include "common/core/hash.h"

#include <openssl/evp.h>

#include "common/core/error.h"

namespace periplus {

struct Sha256::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  ~State() { EVP_MD_CTX_free(context); }
};

Sha256::Sha256() : state_(std::make_unique<State>()) {
  PERIPLUS_ASSERT(state_->context && EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr) == 1);
}
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::update(const void* data, std::size_t bytes) {
  PERIPLUS_ASSERT(EVP_DigestUpdate(state_->context, data, bytes) == 1);
}

std::string Sha256::hex() {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int length = 0;
  PERIPLUS_ASSERT(EVP_DigestFinal_ex(state_->context, digest, &length) == 1);
  static const char digits[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < length; ++i) {
    text += digits[digest[i] >> 4];
    text += digits[digest[i] & 15];
  }
  return text;
}

std::string sha256_hex(std::string_view data) {
  Sha256 hash;
  hash.update(data);
  return hash.hex();
}

std::array<std::uint8_t, 16> md5(const void* data, std::size_t bytes) {
  std::array<std::uint8_t, 16> digest{};
  PERIPLUS_ASSERT(EVP_Digest(data, bytes, digest.data(), nullptr, EVP_md5(), nullptr) == 1);
  return digest;
}

}  // namespace periplus
