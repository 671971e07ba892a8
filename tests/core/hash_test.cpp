#include "core/hash.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

TEST(Sha256, GivesThePublishedDigests) {
  // FIPS 180-2, appendix B, and the digest of the empty text.
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Sha256, DependsOnTheBytesAndNotOnHowTheyAreCut) {
  EXPECT_TRUE(rc::check([](const std::string& text, std::size_t cut) {
    cut %= text.size() + 1;
    Sha256 sum;
    sum.add(text.substr(0, cut)).add(text.substr(cut));
    RC_ASSERT(sum.hex() == sha256(text));
  }));
}

TEST(Sha256, TakesArraysAsTheirBytes) {
  const std::vector<std::uint16_t> values = {0x6261, 0x0063};
  Sha256 sum;
  sum.add(std::span<const std::uint16_t>(values));
  EXPECT_EQ(sum.hex(), sha256(std::string("abc\0", 4)));  // little-endian machines
}

TEST(Sha256, RefusesUseAfterItsEnd) {
  Sha256 sum;
  sum.hex();
  EXPECT_THROW(sum.add("more"), std::logic_error);
  EXPECT_THROW(sum.hex(), std::logic_error);
}

TEST(Sha256, OfAFileIsThatOfItsContent) {
  const TemporaryFolder folder;
  const std::string text(200'000, 'x');
  write_text_durably(folder / "file", text);
  EXPECT_EQ(sha256_file(folder / "file"), sha256(text));
  EXPECT_THROW(sha256_file(folder / "absent"), FileError);
}

}  // namespace
}  // namespace carillon::core
