// Samples of a dataset: whose sound, which object's voxels and picture, and what they are called.
#include "eval/learning/dataset_source.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hdf5.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::eval {
namespace {

constexpr std::uint64_t sounds = 4, listeners = 2, samples = 2205, ticks = 5;

/// Two objects with two strikes each, heard by two listeners, whose tones differ.
class Dataset : public testing::Test {
 protected:
  void SetUp() override {
    const auto file = core::Hdf5Group::create_file(folder_.path() / "index.h5");
    file.write_attribute("sample_rate_hz", 22050.0);
    const std::vector<std::string> keys = {"a/0", "a/1", "b/0", "b/1"};
    file.write<std::string>("key", keys, {sounds});
    const std::vector<std::string> shapes = {"a", "a", "b", "b"};
    file.write<std::string>("shape", shapes, {sounds});
    const std::vector<std::uint32_t> objects = {0, 0, 1, 1};
    file.write<std::uint32_t>("shape_index", objects, {sounds});
    std::vector<float> audio;
    for (std::uint64_t s = 0; s < sounds; ++s) {
      for (std::uint64_t l = 0; l < listeners; ++l) {
        for (std::uint64_t i = 0; i < samples; ++i) audio.push_back(tone(s, l, i));
      }
    }
    file.write<float>("audio", audio, {sounds, listeners, samples});
    std::vector<float> touch(sounds * ticks * 3);
    std::iota(touch.begin(), touch.end(), 1.0F);
    file.write<float>("touch", touch, {sounds, ticks, 3});
    std::vector<std::uint8_t> voxels(std::size_t{2} * 8, 0);
    voxels[3] = 1;
    voxels[8 + 5] = 1;
    const auto shared = file.create_group("shapes");
    shared.write<std::uint8_t>("voxels", voxels, {2, 2, 2, 2});
    nlohmann::json description = {{"seed", 7}, {"shapes", nlohmann::json::array()}};
    for (const char* id : {"a", "b"}) {
      description["shapes"].push_back(
          {{"id", id}, {"request", {{"shape", {{"family", "bar"}, {"length", id}}}}}});
    }
    core::write_text_durably(folder_.path() / "dataset.json", description.dump());
  }

  static float tone(std::uint64_t sound, std::uint64_t listener, std::uint64_t i) {
    const double frequency = 500.0 * static_cast<double>(1 + sound + 4 * listener);
    return static_cast<float>(
        0.5 * std::sin(2 * 3.141592653589793 * frequency * static_cast<double>(i) / 22050.0));
  }

  core::TemporaryFolder folder_;
};

TEST_F(Dataset, GivesTheListenersOwnSound) {
  for (std::size_t listener = 0; listener < listeners; ++listener) {
    const auto source = learning::open_dataset_source(folder_.path(), listener);
    const learning::ModalityLayout layout =
        learning::require_layout(*source, learning::Modality::waveform);
    EXPECT_EQ(layout.entries, sounds);
    ASSERT_EQ(layout.extent, (learning::ModalityExtent{1, samples}));
    std::vector<float> values(2 * samples);
    source->read(learning::Modality::waveform, std::vector<std::uint32_t>{1, 3}, values);
    // At their own rate, with a peak of 1.
    for (std::uint64_t i = 100; i < samples - 100; i += 37) {
      EXPECT_NEAR(values[i], 2 * tone(1, listener, i), 0.02) << listener;
      EXPECT_NEAR(values[samples + i], 2 * tone(3, listener, i), 0.02) << listener;
    }
  }
  EXPECT_THROW(learning::open_dataset_source(folder_.path(), listeners), core::InputError);
}

TEST_F(Dataset, MakesSpectrogramsWhereNoneAreStored) {
  const auto first = learning::open_dataset_source(folder_.path(), 0);
  const auto second = learning::open_dataset_source(folder_.path(), 1);
  const learning::ModalityLayout layout =
      learning::require_layout(*first, learning::Modality::spectrogram);
  const auto bands = static_cast<std::size_t>(layout.extent[1]);
  const std::size_t frames = learning::values_in(layout.extent) / bands;
  const auto loudest_band = [&](learning::SampleSource& source) {
    std::vector<float> values(learning::values_in(layout.extent));
    source.read(learning::Modality::spectrogram, std::vector<std::uint32_t>{0}, values);
    return std::distance(values.begin(), std::max_element(values.begin(), values.end())) /
           static_cast<std::ptrdiff_t>(frames);
  };
  EXPECT_LT(loudest_band(*first), loudest_band(*second));  // 500 and 2,500 Hz
}

TEST_F(Dataset, GivesWhatIsOfObjectsOnceForEach) {
  const auto source = learning::open_dataset_source(folder_.path(), 0);
  const learning::ModalityLayout voxels =
      learning::require_layout(*source, learning::Modality::voxels);
  EXPECT_TRUE(voxels.shared);
  EXPECT_EQ(voxels.entries, 2U);
  EXPECT_EQ(source->entries_of(learning::Modality::voxels),
            (std::vector<std::uint32_t>{0, 0, 1, 1}));
  std::vector<float> values(16);
  source->read(learning::Modality::voxels, std::vector<std::uint32_t>{0, 1}, values);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(values[i], i == 3 || i == 13 ? 1 : -1) << i;
  EXPECT_FALSE(source->layout(learning::Modality::image));
  EXPECT_THROW(learning::require_layout(*source, learning::Modality::image), core::InputError);
}

TEST_F(Dataset, GivesFramesOfObjectsInTheirMaterials) {
  // Object a in one material, b in two; two views of 2 x 1 pixels, each of its own grey.
  const std::filesystem::path other = folder_.path() / "drawn";
  std::filesystem::create_directory(other);
  const auto file = core::Hdf5Group::create_file(other / "index.h5");
  file.write_attribute("sample_rate_hz", 22050.0);
  file.write<std::string>("key", std::vector<std::string>{"a/0", "b/0", "b/1", "a/1"}, {4});
  file.write<float>("audio", std::vector<float>(40, 0.5F), {4, 10});
  file.write<std::uint32_t>("shape_index", std::vector<std::uint32_t>{0, 1, 1, 0}, {4});
  file.write<std::uint32_t>("appearance_index", std::vector<std::uint32_t>{0, 2, 1, 0}, {4});
  std::vector<std::uint8_t> pixels;
  for (std::uint8_t view = 0; view < 6; ++view) pixels.insert(pixels.end(), 6, 51 * view / 2);
  file.create_group("appearances").write<std::uint8_t>("frame", pixels, {3, 2, 2, 1, 3});
  file.flush();
  const auto source = learning::open_dataset_source(other, 0);
  const learning::ModalityLayout layout =
      learning::require_layout(*source, learning::Modality::image);
  EXPECT_TRUE(layout.shared);
  EXPECT_EQ(layout.entries, 3U);
  EXPECT_EQ(layout.extent, (learning::ModalityExtent{2, 3, 64, 64}));
  EXPECT_EQ(source->entries_of(learning::Modality::image),
            (std::vector<std::uint32_t>{0, 2, 1, 0}));
  const std::size_t each = std::size_t{3} * 64 * 64;
  std::vector<float> values(4 * each);
  source->read(learning::Modality::image, std::vector<std::uint32_t>{0, 2}, values);
  for (std::size_t i = 0; i < values.size(); i += 101) {
    const int view = static_cast<int>(i / each);
    const int grey = 51 * (view < 2 ? view : view + 2) / 2;
    EXPECT_NEAR(values[i], static_cast<float>(grey) / 255, 1e-6) << i;
  }
}

TEST_F(Dataset, OfAnOlderVersionHasNoFramesAndSaysWhy) {
  const auto file = core::Hdf5Group::create_file(folder_.path() / "index.h5");
  file.write_attribute("sample_rate_hz", 22050.0);
  file.write<std::string>("key", std::vector<std::string>{"a/0"}, {1});
  file.write<float>("audio", std::vector<float>(10, 0.5F), {1, 10});
  file.write<std::uint32_t>("shape_index", std::vector<std::uint32_t>{0}, {1});
  file.create_group("shapes").write<std::uint8_t>("frame", std::vector<std::uint8_t>(6),
                                                  {1, 2, 1, 3});
  file.flush();
  std::filesystem::remove(folder_.path() / "dataset.json");
  const auto source = learning::open_dataset_source(folder_.path(), 0);
  EXPECT_TRUE(source->layout(learning::Modality::waveform));
  try {
    learning::require_layout(*source, learning::Modality::image);
    FAIL() << "has frames";
  } catch (const core::InputError& error) {
    EXPECT_NE(error.hint().find("older version"), std::string::npos);
  }
}

TEST_F(Dataset, GivesEntriesThatLieFarApartAsItGivesEachAlone) {
  // Of 400 kB: more than is read over.
  constexpr std::uint64_t rows = 100, values_each = 1000;
  std::vector<float> touch(rows * values_each * 3);
  for (std::size_t i = 0; i < touch.size(); ++i) {
    touch[i] = static_cast<float>((i * 7919 + i / 300) % 1000) - 500;
  }
  const std::filesystem::path other = folder_.path() / "far";
  std::filesystem::create_directory(other);
  const auto file = core::Hdf5Group::create_file(other / "index.h5");
  file.write_attribute("sample_rate_hz", 22050.0);
  std::vector<std::string> keys;
  for (std::uint64_t row = 0; row < rows; ++row) keys.push_back(std::to_string(row));
  file.write<std::string>("key", keys, {rows});
  file.write<float>("audio", std::vector<float>(rows * 10, 0.5F), {rows, 10});
  file.write<float>("touch", touch, {rows, values_each, 3});
  file.flush();
  const auto source = learning::open_dataset_source(other, 0);
  const std::vector<std::uint32_t> entries = {0, 1, 3, 50, 97, 99};
  std::vector<float> all(entries.size() * values_each * 3), one(values_each * 3);
  EXPECT_EQ(source->read(learning::Modality::touch, entries, all),
            std::vector<bool>(entries.size(), true));
  for (std::size_t e = 0; e < entries.size(); ++e) {
    source->read(learning::Modality::touch, std::span(entries).subspan(e, 1), one);
    EXPECT_TRUE(std::equal(one.begin(), one.end(), all.begin() + e * one.size())) << entries[e];
  }
}

TEST_F(Dataset, GivesTouchByAxesOfUnitRootMeanSquare) {
  const auto source = learning::open_dataset_source(folder_.path(), 0);
  ASSERT_EQ(learning::require_layout(*source, learning::Modality::touch).extent,
            (learning::ModalityExtent{3, ticks}));
  std::vector<float> values(3 * ticks);
  source->read(learning::Modality::touch, std::vector<std::uint32_t>{1}, values);
  double square = 0;
  for (const float value : values) square += static_cast<double>(value) * value;
  EXPECT_NEAR(square / static_cast<double>(values.size()), 1, 1e-5);
  EXPECT_NEAR(values[1] / values[0], 19.0 / 16.0, 1e-5);      // the next tick of x
  EXPECT_NEAR(values[ticks] / values[0], 17.0 / 16.0, 1e-5);  // y of the first tick
}

TEST_F(Dataset, CallsObjectsAndStrikesAlikeInOtherDatasets) {
  const auto source = learning::open_dataset_source(folder_.path(), 0);
  const std::vector<std::string> objects = source->object_names(), names = source->strike_names();
  EXPECT_EQ(objects[0], objects[1]);
  EXPECT_NE(objects[1], objects[2]);
  EXPECT_NE(names[0], names[1]);
  auto description = nlohmann::json::parse(core::read_file(folder_.path() / "dataset.json"));
  description["seed"] = 8;
  description["shapes"][1]["request"]["shape"]["length"] = "other";
  core::write_text_durably(folder_.path() / "dataset.json", description.dump());
  const auto other = learning::open_dataset_source(folder_.path(), 0);
  EXPECT_EQ(other->object_names()[0], objects[0]);
  EXPECT_NE(other->object_names()[2], objects[2]);  // another object of the same name
  EXPECT_NE(other->strike_names()[0], names[0]);    // another seed: struck elsewhere
}

}  // namespace
}  // namespace carillon::eval
