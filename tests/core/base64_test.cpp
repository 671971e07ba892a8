#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <rapidcheck/gtest.h>

#include "core/base64.hpp"

namespace carillon::core {

TEST(Base64, VectorsOfTheStandard) {
  // RFC 4648, section 10.
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

TEST(Base64, ValuesAreLittleEndian) {
  const std::vector<std::int16_t> values = {1, -2};
  EXPECT_EQ(base64(std::span<const std::int16_t>(values)),
            base64(std::string_view("\1\0\xfe\xff", 4)));
}

TEST(Base64, LongTextsHaveNoSeams) {
  std::string bytes((std::size_t{3} << 24) + 5, 'x');
  bytes[(std::size_t{3} << 24) - 1] = 'y';
  const std::string text = base64(bytes);
  EXPECT_EQ(text.size(), (bytes.size() + 2) / 3 * 4);
  EXPECT_EQ(text.substr(text.size() - 12), base64("xxy") + base64("xxxxx"));
  EXPECT_EQ(text.find('='), text.size() - 1);
}

RC_GTEST_PROP(Base64, ComesBack, (const std::string& bytes)) {
  const std::string text = base64(bytes);
  std::string back(text.size(), '\0');
  EVP_DecodeBlock(reinterpret_cast<unsigned char*>(back.data()),        // NOLINT
                  reinterpret_cast<const unsigned char*>(text.data()),  // NOLINT
                  static_cast<int>(text.size()));
  RC_ASSERT(back.substr(0, bytes.size()) == bytes);
}

}  // namespace carillon::core
