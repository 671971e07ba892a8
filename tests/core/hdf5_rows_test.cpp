#include "core/hdf5_rows.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

namespace fs = std::filesystem;

/// Row r of two values is r, r + 0.5.
std::vector<float> values_of(std::uint64_t row) {
  const auto value = static_cast<float>(row);
  return {value, value + 0.5F};
}

std::string shard_name(std::size_t number) {
  return "shard-" + std::to_string(number) + ".h5";
}

/// index.h5, joined from shards of so many rows.
fs::path write_joined(const fs::path& folder, const std::vector<std::uint64_t>& rows,
                      const StorageOptions& storage) {
  std::vector<VirtualSource> audio, names;
  std::uint64_t row = 0;
  for (std::size_t shard = 0; shard < rows.size(); ++shard) {
    const auto file = Hdf5Group::create_file(folder / shard_name(shard));
    std::vector<float> values;
    std::vector<std::string> texts;
    for (std::uint64_t i = 0; i < rows[shard]; ++i, ++row) {
      const std::vector<float> own = values_of(row);
      values.insert(values.end(), own.begin(), own.end());
      texts.push_back("row " + std::to_string(row));
    }
    file.write("audio", std::span<const float>(values), {rows[shard], 2}, storage);
    file.write("name", std::span<const std::string>(texts), {rows[shard]});
    audio.push_back({shard_name(shard), "audio", rows[shard]});
    names.push_back({shard_name(shard), "name", rows[shard]});
  }
  const auto index = Hdf5Group::create_file(folder / "index.h5");
  index.write_virtual("audio", folder, audio);
  index.write_virtual("name", folder, names);
  return folder / "index.h5";
}

std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const FileError& error) {
    return error.what();
  }
  return "nothing went wrong";
}

RC_GTEST_PROP(Hdf5Rows, AreReadInAnyOrder, ()) {
  const TemporaryFolder folder;
  const auto shards = *rc::gen::nonEmpty(
      rc::gen::container<std::vector<std::uint64_t>>(rc::gen::inRange<std::uint64_t>(1, 9)));
  const auto chunk = *rc::gen::inRange<std::uint64_t>(0, 5);
  const auto index =
      Hdf5Group::open_file(write_joined(folder.path(), shards, {chunk, chunk > 0 ? 1 : 0}));
  const Hdf5Rows rows(index, "audio");
  const auto wanted = *rc::gen::container<std::vector<std::uint64_t>>(
      rc::gen::inRange<std::uint64_t>(0, rows.extent()[0]));
  std::vector<float> values(2 * wanted.size());
  rows.read<float>(wanted, values);
  std::vector<std::string> names(wanted.size());
  Hdf5Rows(index, "name").read<std::string>(wanted, names);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const std::vector<float> own = values_of(wanted[i]);
    RC_ASSERT(
        std::equal(own.begin(), own.end(), values.begin() + static_cast<std::ptrdiff_t>(2 * i)));
    RC_ASSERT(names[i] == "row " + std::to_string(wanted[i]));
  }
}

TEST(Hdf5Rows, OfMoreFilesThanAreKeptOpenAreRead) {
  const TemporaryFolder folder;
  const std::vector<std::uint64_t> shards(600, 1);
  const auto index = Hdf5Group::open_file(write_joined(folder.path(), shards, {}));
  const Hdf5Rows rows(index, "audio");
  for (std::uint64_t i = 0; i < 1200; ++i) {
    const std::uint64_t row = i * 7 % shards.size();
    EXPECT_EQ(rows.read<float>(row, 1), values_of(row));
  }
}

TEST(Hdf5Rows, OfALostFileAreAnErrorThatNamesIt) {
  const TemporaryFolder folder;
  const fs::path path = write_joined(folder.path(), {3, 2}, {1, 1});
  fs::remove(folder / shard_name(1));
  const auto index = Hdf5Group::open_file(path);
  const Hdf5Rows rows(index, "audio");
  EXPECT_EQ(rows.read<float>(2, 1), values_of(2));
  const std::string message = message_of([&] { rows.read<float>(2, 2); });
  EXPECT_NE(message.find(shard_name(1)), std::string::npos) << message;
  EXPECT_NE(message.find("rows 3 to 4 of audio"), std::string::npos) << message;
  EXPECT_THROW(index.read<float>("audio"), FileError);
  EXPECT_THROW(index.read<std::string>("name"), FileError);
}

TEST(Hdf5Rows, OfATruncatedFileAreAnErrorThatNamesIt) {
  const TemporaryFolder folder;
  const fs::path path = write_joined(folder.path(), {3, 200}, {1, 1});
  fs::resize_file(folder / shard_name(1), fs::file_size(folder / shard_name(1)) / 2);
  const auto index = Hdf5Group::open_file(path);
  const std::string message = message_of([&] { index.read_rows<float>("audio", 10, 1); });
  EXPECT_NE(message.find(shard_name(1)), std::string::npos) << message;
  EXPECT_NE(message.find("truncated"), std::string::npos) << message;
}

TEST(Hdf5Rows, OfAFileThatHasBecomeAnotherAreAnError) {
  const TemporaryFolder folder;
  const fs::path path = write_joined(folder.path(), {3, 2}, {});
  const float one[] = {1, 2};
  Hdf5Group::create_file(folder / shard_name(1))
      .write("audio", std::span<const float>(one), {1, 2});
  const std::string message =
      message_of([&] { Hdf5Group::open_file(path).read_rows<float>("audio", 3, 1); });
  EXPECT_NE(message.find("an array of [1, 2] where [2, 2] was joined"), std::string::npos)
      << message;
}

TEST(Hdf5Rows, OutsideTheArrayAreAnError) {
  const TemporaryFolder folder;
  const auto index = Hdf5Group::open_file(write_joined(folder.path(), {3, 2}, {}));
  const Hdf5Rows rows(index, "audio");
  const std::vector<std::uint64_t> wanted{0, 5};
  std::vector<float> values(4);
  EXPECT_THROW(rows.read<float>(wanted, values), FileError);
  EXPECT_THROW(rows.read<float>(4, 2), FileError);
  EXPECT_THROW(Hdf5Rows(index, "none"), FileError);
}

TEST(Hdf5Rows, OfALostFileAreNoNumbersToWhoAsksHdf5Alone) {
  const TemporaryFolder folder;
  const fs::path path = write_joined(folder.path(), {3, 2}, {});
  fs::remove(folder / shard_name(1));
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t audio = H5Dopen2(file, "audio", H5P_DEFAULT);
  std::vector<float> values(10);
  ASSERT_GE(H5Dread(audio, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
  H5Dclose(audio);
  H5Fclose(file);
  EXPECT_EQ(values[5], 2.5F);
  for (std::size_t i = 6; i < 10; ++i) EXPECT_TRUE(std::isnan(values[i]));
}

}  // namespace
}  // namespace carillon::core
