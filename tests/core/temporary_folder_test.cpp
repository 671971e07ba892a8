#include "core/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace carillon::core {
namespace {

namespace fs = std::filesystem;

TEST(TemporaryFolder, AllGoAtOnceWhateverIsInThem) {
  const TemporaryFolder outside;
  fs::path gone;
  {
    const TemporaryFolder one, two;
    fs::create_directories(one / "a" / "b");
    // More than one block of directory entries.
    for (int i = 0; i < 500; ++i) std::ofstream(one / "a" / ("file-" + std::to_string(i))) << i;
    std::ofstream(two / "reply.cbor") << "x";
    fs::create_directory_symlink("/proc", two / "link");
    remove_temporary_folders();
    EXPECT_FALSE(fs::exists(one.path()));
    EXPECT_FALSE(fs::exists(two.path()));
    EXPECT_FALSE(fs::exists(outside.path()));
    gone = one.path();
  }
  EXPECT_TRUE(fs::exists("/proc/self"));
  fs::create_directory(gone);  // as another process may
  remove_temporary_folders();
  EXPECT_TRUE(fs::exists(gone));
  fs::remove(gone);
}

TEST(TemporaryFolder, MoreThanAreKnownAreNoFault) {
  for (int round = 0; round < 3; ++round) {
    std::vector<std::unique_ptr<TemporaryFolder>> many;
    for (int i = 0; i < 40; ++i) many.push_back(std::make_unique<TemporaryFolder>());
    for (const auto& one : many) EXPECT_TRUE(fs::exists(one->path()));
  }
}

}  // namespace
}  // namespace carillon::core
