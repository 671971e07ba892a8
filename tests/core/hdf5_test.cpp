#include "core/hdf5.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <thread>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

using Texts = std::vector<std::string>;

template <class T>
void write(const Hdf5Group& group, const std::string& name, const std::vector<T>& values,
           const Extent& extent, const StorageOptions& storage = {}) {
  group.write(name, std::span<const T>(values), extent, storage);
}

template <class Call>
std::string refusal(const Call& call) {
  testing::internal::CaptureStderr();
  std::string message = "accepted";
  try {
    call();
  } catch (const FileError& error) {
    message = error.message();
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "HDF5 printed an error of its own";
  return message;
}

template <class T>
class Hdf5Element : public testing::Test {};
using Elements =
    testing::Types<float, double, std::int8_t, std::int16_t, std::int32_t, std::int64_t,
                   std::uint8_t, std::uint16_t, std::uint32_t, std::uint64_t>;
TYPED_TEST_SUITE(Hdf5Element, Elements);

TYPED_TEST(Hdf5Element, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  const TypeParam low = std::numeric_limits<TypeParam>::lowest();
  const TypeParam high = std::numeric_limits<TypeParam>::max();
  const std::vector<TypeParam> values = {low, 1, 2, 3, 4, high};
  {
    const auto file = Hdf5Group::create_file(folder / "a.h5");
    write(file, "plain", values, {2, 3});
    write(file, "packed", values, {3, 2}, {2, 9});
    write(file, "single", std::vector<TypeParam>{high}, {});
    write(file, "none", std::vector<TypeParam>{}, {0, 4}, {16, 1});
    file.create<TypeParam>("rows", {4, 2}, {1, 4});
    file.write_rows("rows", 1, std::span<const TypeParam>(values).subspan(2, 4));
  }
  const auto file = Hdf5Group::open_file(folder / "a.h5");
  EXPECT_EQ(file.read<TypeParam>("plain"), values);
  EXPECT_EQ(file.extent("plain"), (Extent{2, 3}));
  EXPECT_EQ(file.read<TypeParam>("packed"), values);
  EXPECT_EQ(file.read<TypeParam>("single"), std::vector<TypeParam>{high});
  EXPECT_TRUE(file.extent("single").empty());
  EXPECT_TRUE(file.read<TypeParam>("none").empty());
  EXPECT_EQ(file.extent("none"), (Extent{0, 4}));
  EXPECT_EQ(file.read<TypeParam>("rows"), (std::vector<TypeParam>{0, 0, 2, 3, 4, high, 0, 0}));
  EXPECT_EQ(file.read_rows<TypeParam>("packed", 1, 2), (std::vector<TypeParam>{2, 3, 4, high}));
  EXPECT_TRUE(file.read_rows<TypeParam>("packed", 3, 0).empty());
}

TEST(Hdf5, ReadsBackTexts) {
  const TemporaryFolder folder;
  const Texts words = {"cup", "", "caf\u00e9", std::string(70'000, 'x')};
  {
    const auto file = Hdf5Group::create_file(folder / "a.h5");
    write(file, "words", words, {4});
    write(file, "packed", words, {2, 2}, {1, 6});
    file.create<std::string>("rows", {3}, {2, 0});
    file.write_rows("rows", 1, std::span<const std::string>(words).subspan(2, 1));
  }
  const auto file = Hdf5Group::open_file(folder / "a.h5");
  EXPECT_EQ(file.read<std::string>("words"), words);
  EXPECT_EQ(file.read<std::string>("packed"), words);
  EXPECT_EQ(file.read_rows<std::string>("words", 1, 2), (Texts{"", "caf\u00e9"}));
  EXPECT_EQ(file.read<std::string>("rows"), (Texts{"", "caf\u00e9", ""}));
}

TEST(Hdf5, ArraysOfAnyShapeAndStorageReadBack) {
  const TemporaryFolder folder;
  EXPECT_TRUE(rc::check([&] {
    const auto extent =
        *rc::gen::resize(4, rc::gen::container<Extent>(rc::gen::inRange<std::uint64_t>(0, 6)));
    const auto count =
        std::accumulate(extent.begin(), extent.end(), std::uint64_t{1}, std::multiplies<>());
    std::vector<float> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<float>(i) * 0.5F;
    StorageOptions storage;
    storage.chunk_rows = *rc::gen::inRange<std::uint64_t>(0, 9);
    if (storage.chunk_rows > 0) storage.deflate = *rc::gen::inRange(0, 10);
    {
      const auto file = Hdf5Group::create_file(folder / "a.h5");
      write(file, "x", values, extent, storage);
    }
    const auto file = Hdf5Group::open_file(folder / "a.h5");
    RC_ASSERT(file.extent("x") == extent);
    RC_ASSERT(file.read<float>("x") == values);
  }));
}

/// A tone above noise: of four bytes of a number the upper one repeats itself, the others do not.
TEST(Hdf5, SoundsShrinkByWhatRepeatsItself) {
  const TemporaryFolder folder;
  constexpr std::uint64_t rows = 7, width = 40000;
  std::vector<float> values(rows * width);
  std::uint32_t noise = 1;
  for (std::size_t i = 0; i < values.size(); ++i) {
    noise = 1664525 * noise + 1013904223;
    values[i] = static_cast<float>(std::sin(0.05 * static_cast<double>(i)) +
                                   1e-9 * static_cast<double>(noise));
  }
  const std::filesystem::path path = folder / "a.h5";
  // Chunks of three rows: the last one is not full.
  write(Hdf5Group::create_file(path), "x", values, {rows, width}, {.chunk_rows = 3, .deflate = 1});
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  // zlib's first level takes 9 rows' bytes to 0.85 of 7 rows'.
  EXPECT_LT(bytes, 0.88 * 4 * static_cast<double>(values.size()));
  const auto file = Hdf5Group::open_file(path);
  EXPECT_EQ(file.read<float>("x"), values);
  const auto row = file.read_rows<float>("x", 6, 1);
  EXPECT_TRUE(std::equal(row.begin(), row.end(), values.begin() + 6 * width));
}

TEST(Hdf5, WhatDoesNotShrinkIsLeftAsItIs) {
  const TemporaryFolder folder;
  std::vector<std::uint64_t> values(10000);
  std::uint64_t noise = 1;
  for (std::uint64_t& value : values) {
    noise = 6364136223846793005u * noise + 1442695040888963407u;
    value = noise ^ noise >> 29;
  }
  const std::filesystem::path path = folder / "a.h5";
  write(Hdf5Group::create_file(path), "x", values, {10000}, {.chunk_rows = 10000, .deflate = 9});
  EXPECT_LT(std::filesystem::file_size(path), 8 * values.size() + 6000);
  EXPECT_EQ(Hdf5Group::open_file(path).read<std::uint64_t>("x"), values);
}

TEST(Hdf5, GroupsAndPaths) {
  const TemporaryFolder folder;
  {
    const auto file = Hdf5Group::create_file(folder / "a.h5");
    const auto modes = file.create_group("modes/cup");
    write(modes, "frequency", std::vector<double>{1, 2}, {2});
    write(file, "labels/material", std::vector<std::int8_t>{3}, {1});
    write(file, "Z", std::vector<float>{1}, {1});
    write(file, "b", std::vector<float>{1}, {1});
  }
  const auto file = Hdf5Group::open_file(folder / "a.h5");
  EXPECT_EQ(file.names(), (Texts{"Z", "b", "labels", "modes"}));
  EXPECT_TRUE(file.has("modes/cup/frequency"));
  EXPECT_FALSE(file.has("modes/bar/frequency"));
  EXPECT_FALSE(file.has("absent"));
  EXPECT_FALSE(file.has("b/below"));
  EXPECT_EQ(file.open_group("modes").open_group("cup").read<double>("frequency"),
            (std::vector<double>{1, 2}));
  EXPECT_EQ(file.open_group("modes").names(), Texts{"cup"});
}

TEST(Hdf5, Attributes) {
  const TemporaryFolder folder;
  {
    const auto file = Hdf5Group::create_file(folder / "a.h5");
    write(file, "audio", std::vector<float>{1}, {1});
    file.write_attribute("title", std::string("old"));
    file.write_attribute("title", std::string("caf\u00e9"));
    file.write_attribute("empty", std::string());
    file.write_attribute("sample_rate", 44100.5, "audio");
    file.write_attribute("seed", std::int64_t{-7});
    file.write_attribute("unit", std::string("Pa"), "audio");
  }
  const auto file = Hdf5Group::open_file(folder / "a.h5");
  EXPECT_EQ(file.text_attribute("title"), "caf\u00e9");
  EXPECT_EQ(file.text_attribute("empty"), "");
  EXPECT_EQ(file.text_attribute("unit", "audio"), "Pa");
  EXPECT_EQ(file.number_attribute("sample_rate", "audio"), 44100.5);
  EXPECT_EQ(file.number_attribute("seed"), -7);
  EXPECT_THROW(file.text_attribute("seed"), FileError);
  EXPECT_THROW(file.number_attribute("title"), FileError);
  EXPECT_THROW(file.text_attribute("absent"), FileError);
  EXPECT_THROW(file.text_attribute("x", "absent"), FileError);
}

TEST(Hdf5, ReadsTextsOfFixedLengthFromOtherWriters) {
  const TemporaryFolder folder;
  {
    const Hdf5Object file(
        H5Fcreate((folder / "a.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
    for (const bool spaces : {false, true}) {
      const Hdf5Object type(H5Tcopy(H5T_C_S1), H5Tclose);
      H5Tset_size(type.get(), 4);
      H5Tset_strpad(type.get(), spaces ? H5T_STR_SPACEPAD : H5T_STR_NULLPAD);
      const hsize_t size = 2;
      const Hdf5Object space(H5Screate_simple(1, &size, nullptr), H5Sclose);
      const Hdf5Object data(H5Dcreate2(file.get(), spaces ? "spaces" : "nulls", type.get(),
                                       space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                            H5Dclose);
      ASSERT_GE(H5Dwrite(data.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                         spaces ? "ab  four" : "ab\0\0four"),
                0);
    }
  }
  const auto file = Hdf5Group::open_file(folder / "a.h5");
  EXPECT_EQ(file.read<std::string>("nulls"), (Texts{"ab", "four"}));
  EXPECT_EQ(file.read<std::string>("spaces"), (Texts{"ab", "four"}));
}

void write_everything(const std::filesystem::path& path) {
  const auto file = Hdf5Group::create_file(path);
  std::vector<float> audio(5000);
  for (std::size_t i = 0; i < audio.size(); ++i) audio[i] = static_cast<float>(i % 97) * 0.01F;
  write(file, "audio", audio, {10, 500}, {4, 5});
  write(file, "plain", audio, {5000});
  write(file, "names", Texts{"a", "", "caf\u00e9"}, {3});
  file.create<double>("later", {5, 3}, {2, 1});
  const std::vector<double> row = {1, 2, 3};
  file.write_rows("later", 3, std::span<const double>(row));
  const auto group = file.create_group("modes/cup");
  write(group, "frequency", std::vector<double>{100.5}, {1});
  group.write_attribute("unit", std::string("Hz"), "frequency");
  file.write_attribute("seed", std::int64_t{4});
  file.write_attribute("text", std::string("longer than the one before"));
  file.write_attribute("text", std::string("short"));
  file.flush();
}

TEST(Hdf5, EqualContentsGiveEqualBytes) {
  const TemporaryFolder folder;
  write_everything(folder / "a.h5");
  // Times are kept in seconds; and memory that was used before must not shine through.
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  std::vector<std::vector<char>> dirt;
  for (std::size_t i = 0; i < 300; ++i) dirt.emplace_back(100 + 97 * i, static_cast<char>(0xa5));
  dirt.clear();
  write_everything(folder / "b.h5");
  EXPECT_EQ(sha256_file(folder / "a.h5"), sha256_file(folder / "b.h5"));
}

TEST(Hdf5, ErrorsNameFileObjectAndReason) {
  const TemporaryFolder folder;
  const std::string path = (folder / "a.h5").string();
  EXPECT_NE(refusal([&] { Hdf5Group::open_file(path); }).find("No such file"), std::string::npos);
  write_text_durably(folder / "text.h5", "not HDF5");
  EXPECT_NE(refusal([&] { Hdf5Group::open_file(folder / "text.h5"); }).find("text.h5: cannot be "),
            std::string::npos);
  EXPECT_NE(refusal([&] { Hdf5Group::create_file(folder / "absent/a.h5"); }).find("No such file"),
            std::string::npos);

  const auto file = Hdf5Group::create_file(path);
  write(file, "x", std::vector<float>{1, 2, 3, 4}, {2, 2});
  write(file, "words", Texts{"a"}, {1});
  const auto message = [&](const auto& call) {
    const std::string text = refusal(call);
    EXPECT_EQ(text.substr(0, path.size() + 2), path + ": ") << text;
    return text.substr(std::min(text.size(), path.size() + 2));
  };
  const std::vector<float> three = {1, 2, 3};
  EXPECT_EQ(message([&] {
              write(file, "y", three, {2, 2});
            }),
            "y: 3 values do not fill an array of [2, 2]");
  EXPECT_EQ(message([&] {
              write(file, "y", three, {3}, {0, 5});
            }),
            "y: compression needs chunks (chunk_rows)");
  EXPECT_EQ(message([&] {
              write(file, "y", three, {3}, {1, 10});
            }),
            "y: deflate is 0 to 9, not 10");
  EXPECT_EQ(message([&] { write(file, "x", three, {3}); }).substr(0, 20), "x: cannot be made: n");
  EXPECT_EQ(message([&] { file.read<float>("absent"); }).substr(0, 26),
            "absent: cannot be opened: ");
  EXPECT_EQ(message([&] { file.read_rows<float>("x", 1, 2); }),
            "x: rows 1 to 3 lie outside an array of [2, 2]");
  EXPECT_EQ(message([&] { file.write_rows("x", 0, std::span<const float>(three)); }),
            "x: 3 values from row 0 on do not fit an array of [2, 2]");
  EXPECT_EQ(message([&] { file.read<float>("words"); }), "words: holds texts, not numbers");
  EXPECT_EQ(message([&] { file.read<std::string>("x"); }), "x: holds no texts");
  EXPECT_EQ(message([&] { write(file, "z", Texts{std::string("a\0b", 3)}, {1}); }),
            "z: a text with a zero byte");
  EXPECT_EQ(message([&] { file.create_group("x"); }).substr(0, 26), "x: group cannot be made: n");
  EXPECT_EQ(message([&] { file.open_group("none"); }).substr(0, 29),
            "none: group cannot be opened:");
}

TEST(Hdf5, AnOpenedFileIsForReadingOnly) {
  const TemporaryFolder folder;
  Hdf5Group::create_file(folder / "a.h5");
  const auto file = Hdf5Group::open_file(folder / "a.h5");
  EXPECT_THROW(write(file, "x", std::vector<float>{1}, {1}), FileError);
  EXPECT_THROW(file.write_attribute("x", 1.0), FileError);
}

TEST(Hdf5, AFullDiskIsReportedByFlush) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const TemporaryFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "full.h5");
  const auto written = [&] {
    try {
      const auto file = Hdf5Group::create_file(folder / "full.h5");
      write(file, "x", std::vector<float>(100'000, 1.0F), {100'000});
      file.flush();
    } catch (const FileError&) {
      ::_exit(7);
    }
    ::_exit(0);
  };
  // In a process of its own, as HDF5 keeps what it could not write until the process ends.
  EXPECT_EXIT(written(), testing::ExitedWithCode(7), "");
}

TEST(Hdf5, DamagedFilesGiveValuesOrAnError) {
  const TemporaryFolder folder;
  write_everything(folder / "good.h5");
  const std::string good = read_file(folder / "good.h5");
  EXPECT_TRUE(rc::check([&] {
    const std::string bytes = good.substr(0, *rc::gen::inRange<std::size_t>(0, good.size()));
    std::ofstream(folder / "damaged.h5", std::ios::binary) << bytes;
    try {
      const auto file = Hdf5Group::open_file(folder / "damaged.h5");
      for (const std::string& name : file.names()) {
        if (name == "audio") RC_ASSERT(file.read<float>(name).size() == 5000u);
      }
    } catch (const FileError& error) {
      RC_ASSERT(!error.message().empty());
    }
  }));
}

}  // namespace
}  // namespace carillon::core
