// Sounds of one's own as samples: labels from names and tables, splits, and clips from the strike
// on.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <set>

#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "eval/learning/recordings_source.hpp"

namespace carillon::eval {
namespace {

namespace fs = std::filesystem;
using Texts = std::vector<std::string>;

/// A tone that decays after some silence.
core::AudioClip struck(double frequency, double lead = 0, int sample_rate = 44100,
                       int channels = 1) {
  core::AudioClip clip{{}, channels, sample_rate};
  const auto count = static_cast<int>((0.5 + lead) * sample_rate);
  for (int i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / sample_rate - lead;
    const double value =
        t < 0 ? 0 : 0.4 * std::exp(-12 * t) * std::sin(2 * std::numbers::pi * frequency * t);
    for (int c = 0; c < channels; ++c) clip.samples.push_back(static_cast<float>(value));
  }
  return clip;
}

class Recordings : public testing::Test {
 protected:
  void put(const std::string& name, const core::AudioClip& clip) {
    fs::create_directories((folder_.path() / name).parent_path());
    core::write_wav(folder_.path() / name, clip, core::SampleFormat::float32);
  }
  /// Objects of two materials, three simulations each.
  void put_objects() {
    for (const char* object : {"glass/cup", "glass/bowl", "wood/spoon", "wood/bowl"}) {
      for (int take = 0; take < 3; ++take) {
        put(std::string(object) + "-" + std::to_string(take) + ".wav",
            struck(500 + 100 * tones_++));
      }
    }
  }
  learning::RecordingsSpec spec(const std::string& names) const {
    learning::RecordingsSpec spec;
    spec.folder = folder_.path();
    spec.names = names;
    spec.seconds = 0.4;
    return spec;
  }
  std::string error_of(const learning::RecordingsSpec& spec, const std::string& column = "") const {
    try {
      const auto source = learning::open_recordings(spec);
      if (!column.empty()) source->labels(column);
    } catch (const core::Error& error) {
      return error.message();
    }
    return "";
  }

  core::TemporaryFolder folder_;
  int tones_ = 0;
};

TEST_F(Recordings, HaveLabelsInTheirNames) {
  put_objects();
  const auto source = learning::open_recordings(spec("{material}/{shape}-*.wav"));
  ASSERT_EQ(source->size(), 12U);
  EXPECT_EQ(source->keys()[0], "glass/bowl-0.wav");
  EXPECT_EQ(source->labels("material")[0], "glass");
  EXPECT_EQ(source->labels("shape")[0], "bowl");
  EXPECT_EQ(source->labels("shape")[11], "spoon");
  // Objects are told apart by their column: here both bowls are one.
  const std::vector<std::string> objects = source->object_names();
  EXPECT_EQ(std::set(objects.begin(), objects.end()).size(), 3U);
  EXPECT_NE(error_of(spec("{material}/cup-*"), "").find("bowl-0.wav does not fit"),
            std::string::npos);
  EXPECT_NE(error_of(spec("*.wav")).find("hold no label"), std::string::npos);
  EXPECT_NE(error_of(spec("{a}/{a}-*")).find("cannot be read"), std::string::npos);
  EXPECT_NE(error_of(spec("{material}/{shape}-*"), "weight").find("no column"), std::string::npos);
}

TEST_F(Recordings, OfNamesThatCanBeReadInTwoWaysAreRefused) {
  put("Steel-bowl-03.WAV", struck(40));
  EXPECT_EQ(learning::open_recordings(spec("{material}-bowl-*.wav"))->labels("material"),
            (Texts{"Steel"}));
  put("sterling_steel_bowl_03.wav", struck(40));
  fs::remove(folder_.path() / "Steel-bowl-03.WAV");
  EXPECT_NE(error_of(spec("{material}_{shape}_*")).find("may be sterling or sterling_steel"),
            std::string::npos);
}

TEST_F(Recordings, HaveLabelsInATable) {
  put_objects();
  learning::RecordingsSpec own = spec("");
  own.table = folder_.path() / "labels.csv";
  own.object = "owner";
  std::ofstream(own.table) << "owner,file,material,split\n"
                              "\"Ann, of old\", wood/spoon-1.wav,wood,test\r\n\n"
                              "Bo,glass/cup-0.wav,glass,train\n";
  const auto source = learning::open_recordings(own);
  EXPECT_EQ(source->keys(), (Texts{"glass/cup-0.wav", "wood/spoon-1.wav"}));
  EXPECT_EQ(source->labels("owner"), (Texts{"Bo", "Ann, of old"}));
  EXPECT_EQ(source->labels("split_shape"), (Texts{"train", "test"}));
  EXPECT_EQ(source->labels("split_strike"), (Texts{"train", "test"}));

  std::ofstream(own.table) << "file,material\nglass/cup-9.wav,glass\n";
  EXPECT_NE(error_of(own).find("labels.csv:2: there is no "), std::string::npos);
  std::ofstream(own.table) << "file,material\nglass/cup-0.wav\n";
  EXPECT_NE(error_of(own).find("labels.csv:2: 1 cells"), std::string::npos);
  std::ofstream(own.table) << "sound,material\n";
  EXPECT_NE(error_of(own).find("no column \"file\""), std::string::npos);
  std::ofstream(own.table) << "file,shape,shape\nglass/cup-0.wav,a,b\n";
  EXPECT_NE(error_of(own).find("\"shape\" stands here twice"), std::string::npos);
  own.object.clear();
  std::ofstream(own.table) << "file,material,,\nglass/cup-0.wav,glass,,\n";
  EXPECT_EQ(error_of(own), "");
  std::ofstream(own.table) << "file,material\nglass/cup-0.wav,m\xFCll\n";
  EXPECT_NE(error_of(own).find("not UTF-8"), std::string::npos);
  std::ofstream(own.table) << "file\nglass/cup-0.wav\nglass/cup-0.wav\n";
  EXPECT_NE(error_of(own).find("stands here twice"), std::string::npos);
}

TEST_F(Recordings, StayInTheirPartsAsMoreCome) {
  put_objects();
  learning::RecordingsSpec half = spec("{material}/{shape}-*");
  half.validation = 0.3;
  half.test = 0.3;
  std::map<std::string, Texts> parts;
  const auto before = learning::open_recordings(half);
  for (const char* column : {"split_shape", "split_strike"}) {
    const Texts labels = before->labels(column);
    for (std::size_t i = 0; i < labels.size(); ++i) {
      parts[before->keys()[i]].push_back(labels[i]);
    }
  }
  std::set<std::string> seen;
  for (const auto& [key, both] : parts) seen.insert(both.begin(), both.end());
  EXPECT_EQ(seen.size(), 3U) << "each part has some";
  put("wood/ladle-0.wav", struck(77));
  const auto after = learning::open_recordings(half);
  EXPECT_NE(after->content(), before->content());
  for (std::size_t i = 0; i < after->size(); ++i) {
    const std::string key = after->keys()[i];
    if (!parts.contains(key)) continue;
    EXPECT_EQ((Texts{after->labels("split_shape")[i], after->labels("split_strike")[i]}),
              parts.at(key));
  }
}

TEST_F(Recordings, ThatLeakAreRefused) {
  put("a-0.wav", struck(500));
  put("a-1.wav", struck(600));
  put("b-0.wav", struck(500));
  learning::RecordingsSpec own = spec("");
  own.table = folder_.path() / "labels.csv";
  std::ofstream(own.table) << "file,shape,split\na-0.wav,a,train\na-1.wav,a,test\n";
  EXPECT_EQ(error_of(own, "split_strike"), "");
  EXPECT_NE(error_of(own, "split_shape").find("object a (a-0.wav and a-1.wav)"), std::string::npos);
  std::ofstream(own.table) << "file,shape,split\na-0.wav,a,train\nb-0.wav,b,test\n";
  EXPECT_NE(error_of(own, "split_strike").find("the same sound twice (a-0.wav and b-0.wav)"),
            std::string::npos);
}

TEST_F(Recordings, OfOneStrikeStayInOnePart) {
  for (int strike = 0; strike < 20; ++strike) {
    for (const char* microphone : {"left", "right"}) {
      put("bowl/" + std::to_string(strike) + "_" + microphone + ".wav",
          struck(500 + 10 * tones_++));
    }
  }
  learning::RecordingsSpec own = spec("{shape}/{strike}_{microphone}");
  own.validation = own.test = 0.3;
  const auto apart = [&] {
    const auto source = learning::open_recordings(own);
    const Texts parts = source->labels("split_strike"), strikes = source->labels("strike");
    std::map<std::string, std::set<std::string>> parts_of;
    for (std::size_t i = 0; i < parts.size(); ++i) parts_of[strikes[i]].insert(parts[i]);
    return std::count_if(parts_of.begin(), parts_of.end(),
                         [](const auto& one) { return one.second.size() > 1; });
  };
  EXPECT_GT(apart(), 0);
  own.strike = "strike";
  EXPECT_EQ(apart(), 0);
  const Texts names = learning::open_recordings(own)->strike_names();
  EXPECT_EQ(std::set(names.begin(), names.end()).size(), 20U);
  own.strike = "simulation";
  EXPECT_NE(error_of(own).find("simulation"), std::string::npos);
  own.strike = "strike";
  own.table = folder_.path() / "labels.csv";
  std::ofstream(own.table) << "file,shape,strike,split\nbowl/0_left.wav,bowl,0,train\n"
                              "bowl/0_right.wav,bowl,0,test\n";
  own.names.clear();
  EXPECT_NE(error_of(own, "split_strike").find("one strike (bowl/0_left.wav and bowl/0_right.wav)"),
            std::string::npos);
}

TEST_F(Recordings, AreHeardFromTheStrikeOnAtAnyRateAndNumberOfChannels) {
  put("plain-0.wav", struck(900));
  put("late-0.wav", struck(900, 0.7));
  put("slow-0.wav", struck(900, 0.2, 22050));
  put("both-0.wav", struck(900, 0, 44100, 2));
  const auto source = learning::open_recordings(spec("{shape}-*"));
  const auto layout = source->layout(learning::Modality::spectrogram).value();
  EXPECT_EQ(layout.extent, (learning::ModalityExtent{1, 64, 25}));
  const std::size_t each = learning::values_in(layout.extent);
  std::vector<float> values(4 * each);
  const std::vector<std::uint32_t> all = {0, 1, 2, 3};
  for (const bool heard : source->read(learning::Modality::spectrogram, all, values))
    EXPECT_TRUE(heard);
  // both, late, plain, slow; the tail of the first cells below -40 dB counts little.
  for (const std::size_t other : {0U, 1U, 3U}) {
    double difference = 0;
    for (std::size_t i = 0; i < each; ++i) {
      const float a = values[2 * each + i], b = values[other * each + i];
      if (std::max(a, b) > 0.4F) difference = std::max(difference, std::abs(a - b) + 0.0);
    }
    EXPECT_LT(difference, 0.05) << source->keys()[other];
  }
  EXPECT_FALSE(source->layout(learning::Modality::voxels).has_value());
}

TEST_F(Recordings, OfSilenceAreEmptyAndOfNaNRefused) {
  core::AudioClip clip = struck(500);
  std::fill(clip.samples.begin(), clip.samples.end(), 0.0F);
  put("a-0.wav", clip);
  put("b-0.wav", clip);
  {  // the samples are the end of the file
    const fs::path path = folder_.path() / "b-0.wav";
    const auto end = static_cast<std::streamoff>(fs::file_size(path) - 4 * clip.samples.size());
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    const float nan = std::nanf("");
    file.seekp(end + 4 * 7).write(reinterpret_cast<const char*>(&nan), 4);
  }
  const auto source = learning::open_recordings(spec("{shape}-*"));
  std::vector<float> values(64 * 25);
  EXPECT_EQ(source->read(learning::Modality::spectrogram, std::vector<std::uint32_t>{0}, values),
            std::vector<bool>{false});
  try {
    source->read(learning::Modality::spectrogram, std::vector<std::uint32_t>{1}, values);
    FAIL() << "NaN was taken";
  } catch (const core::Error& error) {
    EXPECT_NE(error.message().find("b-0.wav: sample 7"), std::string::npos) << error.message();
  }
}

}  // namespace
}  // namespace carillon::eval
