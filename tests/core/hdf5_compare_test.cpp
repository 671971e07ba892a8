#include "core/hdf5_compare.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "core/error.hpp"
#include "core/hdf5.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

using Lines = std::vector<std::string>;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Contents {
  std::vector<double> sizes = {1, nan, 3, 4};
  std::vector<std::uint64_t> ids = {1, 2};
  Lines texts = {"bar", "bell"};
  std::string joined = "a.h5";
  std::string unit = "m";
  double rate = 44100;
  bool more = false;
};

void write(const std::filesystem::path& path, const Contents& contents, bool other_layout) {
  const Hdf5Group file = Hdf5Group::create_file(path);
  if (contents.more) file.write<double>("more", contents.sizes, {4});
  file.write<std::uint64_t>("id", contents.ids, {contents.ids.size()});
  const Hdf5Group shapes = file.create_group("shapes");
  shapes.write<std::string>("family", contents.texts, {2});
  StorageOptions storage;
  if (other_layout) storage = {1, 4};
  shapes.write<double>("size", contents.sizes, {2, 2}, storage);
  file.write_attribute("unit", contents.unit, "shapes/size");
  file.write_attribute("rate", contents.rate);
  const VirtualSource source{contents.joined, "id", 2};
  file.write_virtual("joined", path.parent_path(), {&source, 1});
}

Lines compared(const std::function<void(Contents&)>& change, bool other_layout = false) {
  const TemporaryFolder folder;
  for (const char* name : {"a.h5", "b.h5"}) {
    Hdf5Group::create_file(folder / name)
        .write<std::uint64_t>("id", std::vector<std::uint64_t>{7, 8}, {2});
  }
  write(folder / "expected.h5", {}, false);
  Contents changed;
  change(changed);
  write(folder / "file.h5", changed, other_layout);
  return compare_hdf5(folder / "file.h5", folder / "expected.h5");
}

TEST(CompareHdf5, EqualContentsMayLieInAnotherWay) {
  EXPECT_EQ(compared([](Contents&) {}), Lines{});
  EXPECT_EQ(compared([](Contents&) {}, true), Lines{});
}

TEST(CompareHdf5, NamesWhatDiffers) {
  EXPECT_EQ(compared([](Contents& c) { c.sizes[2] = 3.5; }),
            (Lines{"shapes/size: row 1 is 3.5, not 3"}));
  EXPECT_EQ(compared([](Contents& c) { c.sizes[1] = 0; }),
            (Lines{"shapes/size: row 0 is 0, not nan"}));
  EXPECT_EQ(compared([](Contents& c) { c.texts[1] = "bowl"; }),
            (Lines{"shapes/family: row 1 is bowl, not bell"}));
  EXPECT_EQ(compared([](Contents& c) { c.ids[0] = ~std::uint64_t{0}; }),
            (Lines{"id: row 0 is 18446744073709551615, not 1"}));
  EXPECT_EQ(compared([](Contents& c) { c.ids.push_back(3); }),
            (Lines{"id: is uint64[3], not uint64[2]"}));
  EXPECT_EQ(compared([](Contents& c) { c.joined = "b.h5"; }),
            (Lines{"joined: block 0 is 2 rows of b.h5:id, not 2 rows of a.h5:id"}));
  EXPECT_EQ(compared([](Contents& c) { c.unit = "mm"; }),
            (Lines{"shapes/size@unit: is \"mm\", not \"m\""}));
  EXPECT_EQ(compared([](Contents& c) { c.rate = 1; }), (Lines{"@rate: is 1, not 44100"}));
  EXPECT_EQ(compared([](Contents& c) { c.more = true; }), (Lines{"more: does not belong there"}));
}

TEST(CompareHdf5, NamesAFileThatCannotBeRead) {
  const TemporaryFolder folder;
  EXPECT_THROW(compare_hdf5(folder / "a.h5", folder / "b.h5"), FileError);
}

}  // namespace
}  // namespace carillon::core
