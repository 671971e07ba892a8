#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "core/hdf5.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

namespace fs = std::filesystem;
using Texts = std::vector<std::string>;

/// Rows first, first + 1, ... of a table with two columns, and a name for each.
void write_shard(const fs::path& path, int first, std::uint64_t rows) {
  const auto file = Hdf5Group::create_file(path);
  std::vector<float> values;
  Texts names;
  for (std::uint64_t i = 0; i < rows; ++i) {
    const auto row = static_cast<float>(first) + static_cast<float>(i);
    values.insert(values.end(), {row, row + 0.5F});
    names.push_back("row " + std::to_string(first + static_cast<int>(i)));
  }
  file.write("audio", std::span<const float>(values), {rows, 2}, {2, 4});
  file.write("name", std::span<const std::string>(names), {rows});
}

void join(const fs::path& folder, const std::string& index, const Texts& shards,
          const std::vector<std::uint64_t>& rows) {
  const auto file = Hdf5Group::create_file(folder / index);
  for (const char* dataset : {"audio", "name"}) {
    std::vector<VirtualSource> sources;
    for (std::size_t i = 0; i < shards.size(); ++i)
      sources.push_back({shards[i], dataset, rows[i]});
    file.write_virtual(dataset, folder, sources);
  }
}

void expect_joined(const fs::path& index) {
  const auto file = Hdf5Group::open_file(index);
  EXPECT_EQ(file.extent("audio"), (Extent{5, 2}));
  EXPECT_EQ(file.read<float>("audio"),
            (std::vector<float>{0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5}));
  EXPECT_EQ(file.read_rows<float>("audio", 2, 2), (std::vector<float>{2, 2.5, 3, 3.5}));
  EXPECT_EQ(file.read<std::string>("name"), (Texts{"row 0", "row 1", "row 2", "row 3", "row 4"}));
}

TEST(Hdf5Virtual, JoinsRowsOfShards) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "shards");
  write_shard(folder / "shards/a.h5", 0, 3);
  write_shard(folder / "shards/b.h5", 3, 2);
  join(folder.path(), "index.h5", {"shards/a.h5", "shards/b.h5"}, {3, 2});
  expect_joined(folder / "index.h5");
}

TEST(Hdf5Virtual, FollowsItsFolderWhereverItIsRead) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "old/shards");
  write_shard(folder / "old/shards/a.h5", 0, 3);
  write_shard(folder / "old/shards/b.h5", 3, 2);
  join(folder / "old", "index.h5", {"shards/a.h5", "shards/b.h5"}, {3, 2});
  fs::rename(folder / "old", folder / "new");
  expect_joined(folder / "new/index.h5");
  const fs::path before = fs::current_path();
  fs::current_path(folder / "new/shards");
  expect_joined("../index.h5");
  fs::current_path(before);
}

TEST(Hdf5Virtual, PercentSignsInNamesAreNoPatterns) {
  const TemporaryFolder folder;
  write_shard(folder / "100%b.h5", 0, 5);
  join(folder.path(), "index.h5", {"100%b.h5"}, {5});
  expect_joined(folder / "index.h5");
}

TEST(Hdf5Virtual, EqualIndicesAreEqualBytes) {
  const TemporaryFolder folder;
  write_shard(folder / "a.h5", 0, 3);
  write_shard(folder / "b.h5", 3, 2);
  join(folder.path(), "one.h5", {"a.h5", "b.h5"}, {3, 2});
  join(folder.path(), "two.h5", {"a.h5", "b.h5"}, {3, 2});
  EXPECT_EQ(sha256_file(folder / "one.h5"), sha256_file(folder / "two.h5"));
}

TEST(Hdf5Virtual, NamesASourceThatIsNotThere) {
  const TemporaryFolder folder;
  const auto file = Hdf5Group::create_file(folder / "index.h5");
  const std::vector<VirtualSource> absent = {{"absent.h5", "audio", 3}};
  try {
    file.write_virtual("audio", folder.path(), absent);
    FAIL();
  } catch (const FileError& error) {
    EXPECT_NE(error.message().find("absent.h5"), std::string::npos) << error.message();
  }
  EXPECT_THROW(file.write_virtual("audio", folder.path(), {}), FileError);
}

}  // namespace
}  // namespace carillon::core
