// index.h5 as it grows: the same bytes whatever was known before, and no file is read twice.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hdf5.hpp"
#include "core/temporary_folder.hpp"
#include "dataset/run/dataset.hpp"

namespace carillon::dataset {
namespace {

using core::Hdf5Group;

class IndexTest : public testing::Test {
 protected:
  IndexTest()
      : config_(configuration::read_build_config(
            "objects: [{shape: bar, materials: [steel], count: 3}]\nstrikes: {per_object: 2}\n",
            "test.yaml", {})),
        plan_(plan::make_plan(config_)) {
    for (std::size_t t = 0; t < plan_.tasks.size(); ++t) {
      const plan::BuildTask& task = plan_.tasks[t];
      if (task.kind == plan::TaskKind::modes) {
        write_modes(plan_.shapes[task.shape].id);
      } else {
        samples_.push_back(t);
        write_shard(task.key, task.count);
      }
    }
  }

  void write_shard(const std::string& key, std::size_t rows) const {
    const std::vector<float> audio(rows * 3, 0.5F);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < rows; ++i) names.push_back(i == 0 ? "" : key);
    std::filesystem::create_directories(folder_.path() / "samples");
    const Hdf5Group file = Hdf5Group::create_file(folder_.path() / (key + ".h5"));
    file.write_attribute("sample_rate_hz", 8000.0);
    file.write<float>("audio", audio, {rows, 3}, {1, 4});
    file.write<std::string>("key", names, {rows});
    for (const char* name : {"audio", "key"}) file.write_attribute("unit", "1", name);
  }

  void write_modes(const std::string& shape) const {
    const std::vector<std::uint8_t> voxels(8, 1);
    std::filesystem::create_directories(folder_.path() / "modes");
    const Hdf5Group file = Hdf5Group::create_file(folder_.path() / ("modes/" + shape + ".h5"));
    file.write<std::uint8_t>("voxels", voxels, {1, 2, 2, 2});
  }

  /// Bytes of the index of the first shards.
  std::string index_of(std::size_t shards, run::JoinedFiles& joined) const {
    const std::vector<std::size_t> done(samples_.begin(),
                                        samples_.begin() + static_cast<std::ptrdiff_t>(shards));
    run::write_index(config_, plan_, done, {folder_.path(), ""}, folder_.path() / "index.h5",
                     joined);
    return core::read_file(folder_.path() / "index.h5");
  }
  std::string fresh_index_of(std::size_t shards) const {
    run::JoinedFiles joined(folder_.path());
    return index_of(shards, joined);
  }

  core::TemporaryFolder folder_;
  configuration::BuildConfig config_;
  plan::BuildPlan plan_;
  std::vector<std::size_t> samples_;
};

TEST_F(IndexTest, GrowsToTheBytesOfAFreshOneAndReadsNoFileTwice) {
  ASSERT_EQ(samples_.size(), 3u);
  const std::string two = fresh_index_of(2), three = fresh_index_of(3);
  EXPECT_NE(two, three);
  const Hdf5Group index = Hdf5Group::open_file(folder_.path() / "index.h5");
  EXPECT_EQ(index.extent("audio"), (core::Extent{6, 3}));
  EXPECT_EQ(index.extent("shapes/voxels"), (core::Extent{3, 2, 2, 2}));
  EXPECT_EQ(index.read<std::string>("key")[3], plan_.tasks[samples_[1]].key);

  run::JoinedFiles joined(folder_.path());
  EXPECT_EQ(index_of(2, joined), two);
  const std::string second = plan_.tasks[samples_[1]].key + ".h5";
  std::ofstream(folder_.path() / second) << "no HDF5 any more";
  EXPECT_EQ(index_of(3, joined), three);
  EXPECT_THROW(fresh_index_of(3), core::FileError);
  joined.forget(second);
  EXPECT_THROW(index_of(3, joined), core::FileError);
}

TEST_F(IndexTest, AShardThatLacksAColumnIsNamed) {
  const std::string second = plan_.tasks[samples_[1]].key + ".h5";
  Hdf5Group::create_file(folder_.path() / second);
  try {
    fresh_index_of(3);
    FAIL();
  } catch (const core::FileError& error) {
    EXPECT_NE(std::string(error.what()).find(second + ": holds no audio"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace carillon::dataset
