// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace stereogrid::app::batch {

/// SHA-256 of bytes that arrive in pieces, computed by OpenSSL.
class Sha256 {
 public:
  Sha256() : context_{EVP_MD_CTX_new()} {
    require(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
  }
  void add(std::string_view bytes) { require(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1); }
  /// Returns 64 hexadecimal digits; nothing can be added afterwards.
  [[nodiscard]] std::string hex() {
    std::array<unsigned char, 32> bytes{};
    require(EVP_DigestFinal_ex(context_.get(), bytes.data(), nullptr) == 1);
    return fmt::format("{:02x}", fmt::join(bytes, ""));
  }

 private:
  static void require(bool done) {
    if (!done) throw std::runtime_error{"SHA-256 by OpenSSL"};
  }

  struct Free {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
  };
  std::unique_ptr<EVP_MD_CTX, Free> context_;
};

[[nodiscard]] inline std::string sha256_of(std::string_view bytes) {
  Sha256 digest;
  digest.add(bytes);
  return digest.hex();
}

}  // namespace stereogrid::app::batch
