// What networks are given: prepared modalities, tasks, samples of several sources, and files that
// know whether they are whole.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <numeric>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"
#include "eval/learning/clip.hpp"
#include "eval/learning/sealed_file.hpp"
#include "eval/learning/selected_source.hpp"
#include "tests/eval/learning/made_source.hpp"

namespace carillon::eval {
namespace {

TEST(PreparedSpectrogram, IsRelativeToTheLoudestCell) {
  std::vector<float> power = {1e-3F, 1e-6F, 1e-3F * 1e-6F, 1e-12F, 0};
  EXPECT_TRUE(learning::prepare::spectrogram(power));
  const std::vector<float> relative = {1, 1e-3F, 1e-6F, 1e-9F, 0};
  for (std::size_t i = 0; i < power.size(); ++i) EXPECT_FLOAT_EQ(power[i], relative[i]);
  learning::SpectrogramInput{learning::SpectrogramScale::power}.apply(power);
  EXPECT_FLOAT_EQ(power[2], 1e-6F);
  learning::SpectrogramInput{}.apply(power);  // decibels below the loudest cell
  EXPECT_FLOAT_EQ(power[0], 1);
  EXPECT_NEAR(power[1], 0.5, 1e-6);  // 30 of 60 dB
  EXPECT_NEAR(power[2], 0, 1e-6);
  EXPECT_EQ(power[3], 0);
  EXPECT_EQ(power[4], 0);
}

RC_GTEST_PROP(PreparedSpectrogram, DoesNotDependOnLevel, ()) {
  const auto cells =
      *rc::gen::nonEmpty(rc::gen::container<std::vector<int>>(rc::gen::inRange(-90, 1)));
  const double gain = std::pow(10.0, *rc::gen::inRange(-60, 60) / 10.0);
  std::vector<float> quiet, loud;
  for (const int cell : cells) {
    quiet.push_back(static_cast<float>(std::pow(10.0, cell / 10.0)));
    loud.push_back(static_cast<float>(gain * std::pow(10.0, cell / 10.0)));
  }
  learning::prepare::spectrogram(quiet);
  learning::prepare::spectrogram(loud);
  for (std::size_t i = 0; i < quiet.size(); ++i) {
    RC_ASSERT(std::abs(quiet[i] - loud[i]) < 1e-5F);
    RC_ASSERT(quiet[i] >= 0 && quiet[i] <= 1);
  }
}

TEST(PreparedSpectrogram, OfSilenceIsEmptyAndOfNaNRefused) {
  std::vector<float> silence(10, 0.0F);
  EXPECT_FALSE(learning::prepare::spectrogram(silence));
  EXPECT_EQ(silence, std::vector<float>(10, 0.0F));
  std::vector<float> broken = {1, std::numeric_limits<float>::quiet_NaN()};
  EXPECT_THROW(learning::prepare::spectrogram(broken), core::InputError);
  broken[1] = std::numeric_limits<float>::infinity();
  EXPECT_THROW(learning::prepare::spectrogram(broken), core::InputError);
}

TEST(PreparedSpectrogram, HasThePapersExtentForClipsOfAnyLength) {
  EXPECT_EQ(learning::paper_format(44100, 44100).mel.hop, 1837);
  for (const std::size_t samples : {44100U, 48000U, 22050U, 13000U}) {
    const learning::ClipPreparer preparer(learning::paper_format(samples, 44100));
    EXPECT_EQ(preparer.extent(learning::Modality::spectrogram),
              (learning::ModalityExtent{1, 64, 25}))
        << samples;
  }
}

TEST(PreparedWaveform, KeepsATonesFrequencyAndItsPeakIsOne) {
  std::vector<float> clip(44100);
  for (std::size_t i = 0; i < clip.size(); ++i) {
    clip[i] = 0.01F * static_cast<float>(
                          std::sin(2 * std::numbers::pi * 1000 * static_cast<double>(i) / 44100));
  }
  const auto prepared = learning::prepare::waveform(clip, 44100);
  ASSERT_EQ(prepared.size(), 22050u);
  double in = 0, out = 0, maximum = 0;
  for (std::size_t i = 2000; i < 20000; ++i) {
    const double phase = 2 * std::numbers::pi * 1000 * static_cast<double>(i) / 22050;
    in += prepared[i] * std::sin(phase);
    out += prepared[i] * prepared[i];
    maximum = std::max(maximum, static_cast<double>(std::abs(prepared[i])));
  }
  EXPECT_NEAR(in / out, 1, 0.02);  // all of it is that tone, of amplitude 1
  EXPECT_NEAR(maximum, 1, 0.02);
}

TEST(PreparedImage, IsTheMeanOfWhatEachPixelCovers) {
  // 128 x 128: each new pixel covers 2 x 2; red rises with the row, blue with the column.
  std::vector<std::uint8_t> pixels(128 * 128 * 3, 0);
  for (std::size_t y = 0; y < 128; ++y) {
    for (std::size_t x = 0; x < 128; ++x) {
      pixels[(y * 128 + x) * 3] = static_cast<std::uint8_t>(y);
      pixels[(y * 128 + x) * 3 + 2] = static_cast<std::uint8_t>(2 * x);
    }
  }
  std::vector<float> planes(3 * 64 * 64);
  learning::prepare::image(pixels, 128, 128, planes);
  EXPECT_NEAR(planes[10 * 64 + 3], 20.5 / 255, 1e-6);
  EXPECT_EQ(planes[4096 + 77], 0);
  EXPECT_NEAR(planes[2 * 4096 + 10 * 64 + 3], 13.0 / 255, 1e-6);
  // Smaller pictures are drawn larger.
  std::vector<std::uint8_t> one = {255, 0, 51};
  learning::prepare::image(one, 1, 1, planes);
  EXPECT_EQ(planes[0], 1);
  EXPECT_EQ(planes[4095], 1);
  EXPECT_NEAR(planes[3 * 4096 - 1], 0.2, 1e-6);
}

TEST(PreparedTouch, HasUnitRootMeanSquareAxisByAxis) {
  const std::vector<float> force = {1, 2, 3, 4, 5, 6};
  std::vector<float> planes(6);
  learning::prepare::touch(force, planes);
  const double scale = std::sqrt(6.0 / 91);
  const double expected[] = {1, 4, 2, 5, 3, 6};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(planes[i], scale * expected[i], 1e-6);
}

TEST(Task, ClassesDoNotDependOnTheOrderOfLabels) {
  MadeSource source(60, 4), turned(60, 4);
  std::vector<std::string> labels = source.labels("label");
  std::vector<std::string> names = labels;
  std::rotate(names.begin(), names.begin() + 2, names.end());
  turned.columns["label"] = names;
  const auto first = learning::label_samples(source, made_task()),
             second = learning::label_samples(turned, made_task());
  EXPECT_EQ(first.classes, second.classes);
  for (std::size_t i = 0; i < 60; ++i) {
    EXPECT_EQ(first.classes[static_cast<std::size_t>(first.label[i])], labels[i]);
    EXPECT_EQ(second.classes[static_cast<std::size_t>(second.label[i])], names[i]);
  }
}

TEST(Task, ClassesMayHoldSeveralLabelsAndLeaveOthersOut) {
  const MadeSource source(60, 4);
  learning::TaskSpec task = made_task();
  task.classes = {{"low", {"class-0", "class-1"}}, {"high", {"class-3"}}};
  const auto samples = learning::label_samples(source, task);
  EXPECT_EQ(samples.classes, (std::vector<std::string>{"high", "low"}));
  EXPECT_EQ(samples.label[0], 1);
  EXPECT_EQ(samples.label[1], 1);
  EXPECT_EQ(samples.label[2], -1);
  EXPECT_EQ(samples.label[3], 0);
  for (const std::uint32_t row : samples.rows(learning::Part::train)) EXPECT_NE(row % 4, 2u);
  task.classes["high"].push_back("class-0");
  EXPECT_THROW(learning::label_samples(source, task), core::InputError);
}

TEST(Task, RefusesWhatCannotBeLearnt) {
  MadeSource source(20, 2);
  const auto require = [&](const learning::TaskSpec& task) {
    learning::require_learnable(learning::label_samples(source, task), source, task);
  };
  require(made_task());
  source.columns["label"] = std::vector<std::string>(20, "one");
  EXPECT_THROW(require(made_task()), core::InputError);
  source.columns.clear();
  learning::TaskSpec without = made_task();
  without.except = {{"label", {"class-1"}}};
  EXPECT_THROW(require(without), core::InputError);  // one class is left
  without.except = {{"label", {"class-7"}}};
  EXPECT_THROW(require(without), core::InputError);
  source.columns["split"] = std::vector<std::string>(20, "test");
  EXPECT_THROW(require(made_task()), core::InputError);
  source.columns["split"][3] = "tset";
  EXPECT_THROW(learning::label_samples(source, made_task()), core::InputError);
}

TEST(Task, TellsWhatIsLeftOutFromWhatHasNoLabel) {
  MadeSource source(30, 3);
  source.columns["label"] = source.labels("label");
  source.columns["label"][4] = "";
  learning::TaskSpec task = made_task();
  task.except = {{"label", {"class-2"}}};
  const learning::LabelledSamples samples = learning::label_samples(source, task);
  EXPECT_EQ(samples.classes, (std::vector<std::string>{"class-0", "class-1"}));
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(samples.label[i], i == 4       ? learning::unlabelled
                                : i % 3 == 2 ? learning::left_out
                                             : static_cast<std::int32_t>(i % 3));
  }
}

TEST(Task, LeavesOutLabelsOfOtherColumns) {
  MadeSource source(30, 3);
  source.columns["family"] = source.labels("label");
  for (std::size_t i = 0; i < 30; ++i) source.columns["family"][i] = i < 5 ? "bell" : "bar";
  learning::TaskSpec task = made_task();
  task.except = {{"family", {"bell"}}, {"label", {"class-1"}}};
  const learning::LabelledSamples samples = learning::label_samples(source, task);
  EXPECT_EQ(samples.classes, (std::vector<std::string>{"class-0", "class-2"}));
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(samples.label[i] == learning::left_out, i < 5 || i % 3 == 1) << i;
  }
  task.except = {{"family", {"ring"}}};
  EXPECT_THROW(learning::require_learnable(learning::label_samples(source, task), source, task),
               core::InputError);
}

TEST(Task, TellsOfClassesThatAreNotLearntOrNotTested) {
  MadeSource source(60, 4);
  source.columns["split"] = source.labels("split");
  for (std::size_t i = 0; i < 60; ++i) {
    if (i % 4 == 2) source.columns["split"][i] = "test";
    if (i % 4 == 1) source.columns["split"][i] = "train";
  }
  const auto texts = learning::remarks(learning::label_samples(source, made_task()));
  ASSERT_EQ(texts.size(), 2u);
  EXPECT_NE(texts[0].find("nothing is learnt of class-2"), std::string::npos);
  EXPECT_NE(texts[1].find("class-1 not tested"), std::string::npos);
}

TEST(SealedFile, ComesBackWholeOrNotAtAll) {
  const core::TemporaryFolder folder;
  const auto path = folder.path() / "sealed";
  const std::string bytes("a\0b\nc", 5);
  learning::write_sealed(path, {{{"what", "test"}}, {bytes, "", "third"}});
  const learning::SealedFile file = learning::read_sealed(path);
  EXPECT_EQ(file.header.at("what"), "test");
  EXPECT_EQ(file.blocks, (std::vector<std::string>{bytes, "", "third"}));
  const std::string whole = core::read_file(path);
  for (const std::size_t length :
       {std::size_t{0}, std::size_t{10}, whole.size() - 6, whole.size() - 1}) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, length);
    EXPECT_THROW(learning::read_sealed(path), core::InputError) << length;
  }
  std::string changed = whole;
  changed.back() = 'X';
  std::ofstream(path, std::ios::binary) << changed;
  EXPECT_THROW(learning::read_sealed(path), core::InputError);
  changed = whole;
  changed.replace(whole.find("test"), 4, "best");  // in the header
  std::ofstream(path, std::ios::binary) << changed;
  EXPECT_THROW(learning::read_sealed(path), core::InputError);
  EXPECT_THROW(learning::read_sealed(folder.path() / "none"), core::FileError);
}

TEST(SelectedSamples, AreThoseOfTheirSources) {
  MadeSource first(60, 3), second(60, 3, 1.0);
  std::vector<learning::Selection> wanted = {{1, 4, learning::Part::test},
                                             {0, 2, learning::Part::train},
                                             {0, 50, learning::Part::train},
                                             {1, 40, learning::Part::validation}};
  const auto source = learning::select_samples({&first, &second}, wanted);
  ASSERT_EQ(source->size(), 4U);
  EXPECT_EQ(source->keys(),
            (std::vector<std::string>{"0:sample-2", "0:sample-50", "1:sample-4", "1:sample-40"}));
  EXPECT_EQ(source->labels("split_strike"),
            (std::vector<std::string>{"train", "train", "test", "validation"}));
  EXPECT_EQ(source->labels("kind"),
            (std::vector<std::string>{"class-2", "class-2", "class-1", "class-1"}));
  EXPECT_EQ(source->entries_of(learning::Modality::voxels),
            (std::vector<std::uint32_t>{2, 2, 4, 4}));
  for (const learning::Modality modality :
       {learning::Modality::spectrogram, learning::Modality::voxels}) {
    const auto layout = source->layout(modality).value();
    EXPECT_EQ(layout.entries, modality == learning::Modality::voxels ? 6U : 4U);
    const std::size_t each = learning::values_in(layout.extent);
    std::vector<std::uint32_t> all(layout.entries);
    std::iota(all.begin(), all.end(), 0U);
    std::vector<float> values(all.size() * each), own(each);
    EXPECT_EQ(source->read(modality, all, values), std::vector<bool>(all.size(), true));
    for (const std::uint32_t entry : all) {
      const bool object = modality == learning::Modality::voxels;
      MadeSource& theirs = (object ? entry / 3 : entry / 2) == 0 ? first : second;
      const std::uint32_t row =
          object ? entry % 3 : std::vector<std::uint32_t>{2, 50, 4, 40}[entry];
      theirs.read(modality, std::vector<std::uint32_t>{row}, own);
      EXPECT_TRUE(std::equal(own.begin(), own.end(), values.begin() + entry * each)) << entry;
    }
  }
  EXPECT_NE(learning::select_samples({&first, &second}, {wanted[0], wanted[1]})->content(),
            source->content());
  const auto joined =
      learning::select_samples({&first, &second}, {{1, 4}, {0, 2}}, {"real", "made"});
  EXPECT_EQ(joined->labels("dataset"), (std::vector<std::string>{"real", "made"}));
  EXPECT_EQ(joined->labels("split"),
            (std::vector<std::string>{first.labels("split")[2], second.labels("split")[4]}));
  wanted.push_back({0, 50, learning::Part::test});
  EXPECT_THROW(learning::select_samples({&first, &second}, wanted), core::InputError);
  EXPECT_THROW(learning::select_samples({&first}, {}), core::InputError);
}

}  // namespace
}  // namespace carillon::eval
