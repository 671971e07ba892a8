// What descriptions in the Croissant format say of a dataset as a whole.
#include <gtest/gtest.h>

#include "dataset/run/croissant.hpp"

namespace carillon::dataset {
namespace {

std::string license_in(const std::string& license) {
  configuration::About about;
  about.license = license;
  return run::croissant_about("set", about).at("license");
}

TEST(Croissant, GivesLicensesByTheirAddresses) {
  for (const char* identifier :
       {"CC-BY-4.0", "CC0-1.0", "ODbL-1.0", "BSD-3-Clause", "GPL-3.0-only", "MIT"}) {
    EXPECT_EQ(license_in(identifier), std::string("https://spdx.org/licenses/") + identifier);
  }
  for (const char* other : {"https://example.org/license", "ask the author", "proprietary"}) {
    EXPECT_EQ(license_in(other), other);
  }
}

TEST(Croissant, SaysNothingThatWasNotSaid) {
  EXPECT_EQ(run::croissant_about("set", {}), (nlohmann::ordered_json{{"name", "set"}}));
  const auto head = run::croissant_head("set", {}, "so many sounds");
  EXPECT_EQ(head.at("description"), "so many sounds");
  EXPECT_FALSE(head.contains("license"));
}

}  // namespace
}  // namespace carillon::dataset
