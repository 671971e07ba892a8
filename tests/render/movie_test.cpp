#include "render/movie.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "core/audio.hpp"
#include "core/child_process.hpp"
#include "core/error.hpp"
#include "core/hash.hpp"
#include "core/image.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::render {
namespace {

namespace fs = std::filesystem;

void write_frames(const fs::path& folder, int count) {
  for (int k = 0; k < count; ++k) {
    core::Image image{33, 21, 3, {}};
    for (int i = 0; i < 33 * 21 * 3; ++i) image.pixels.push_back(std::uint8_t(i / 9 + 10 * k));
    write_png(frame_path(folder, k), image);
  }
}

/// Sets the PATH for a while.
struct Path {
  std::string before = std::getenv("PATH");
  explicit Path(const char* value) { setenv("PATH", value, 1); }
  ~Path() { setenv("PATH", before.c_str(), 1); }
};

TEST(Movie, HasEveryFrameAndTheSoundAndTheSameBytesAgain) {
  if (!fs::exists("/usr/bin/ffprobe")) GTEST_SKIP() << "no ffmpeg here";
  const core::TemporaryFolder temporary;
  const fs::path folder = temporary.path() / "odd %d name";
  fs::create_directory(folder);
  write_frames(folder, 7);
  core::write_wav(folder / "a.wav", {std::vector<float>(4410 * 3, 0.25F), 1, 44100},
                  core::SampleFormat::int16);
  const fs::path movie = folder / "a.mp4";
  const MovieResult result = make_movie(movie, folder, 25, folder / "a.wav");
  ASSERT_TRUE(result.made) << result.message;
  EXPECT_EQ(result.message, "");
  EXPECT_FALSE(fs::exists(folder / "a.mp4.part"));
  const std::string first = core::sha256_file(movie);
  ASSERT_TRUE(make_movie(movie, folder, 25, folder / "a.wav").made);
  EXPECT_EQ(core::sha256_file(movie), first);
  const auto probe =
      core::run_child("/usr/bin/ffprobe",
                      {"-v", "error", "-count_frames", "-show_entries",
                       "stream=codec_name,nb_read_frames,width", "-of", "csv=p=0", movie.string()},
                      60);
  EXPECT_NE(probe.output.find("h264,34,7"), std::string::npos) << probe.output;
  EXPECT_NE(probe.output.find("aac"), std::string::npos) << probe.output;
}

TEST(Movie, WithoutFfmpegTheFramesStay) {
  const core::TemporaryFolder folder;
  write_frames(folder.path(), 2);
  const Path nowhere("/nonexistent");
  const MovieResult result = make_movie(folder.path() / "a.mp4", folder.path(), 25);
  EXPECT_FALSE(result.made);
  EXPECT_NE(result.message.find("no ffmpeg on the PATH"), std::string::npos);
  EXPECT_TRUE(fs::exists(frame_path(folder.path(), 1)));
  EXPECT_FALSE(fs::exists(folder.path() / "a.mp4"));
}

TEST(Movie, SaysWhatFfmpegSays) {
  const core::TemporaryFolder folder;
  write_frames(folder.path(), 1);
  const fs::path programs = folder.path() / "bin";
  fs::create_directory(programs);
  std::ofstream(programs / "ffmpeg") << "#!/bin/sh\necho it will not do\nexit 3\n";
  fs::permissions(programs / "ffmpeg", fs::perms::owner_all);
  const Path only(programs.c_str());
  const MovieResult result = make_movie(folder.path() / "a.mp4", folder.path(), 25);
  EXPECT_FALSE(result.made);
  EXPECT_NE(result.message.find("it will not do"), std::string::npos) << result.message;
}

TEST(Movie, RefusesWhatCannotBe) {
  const core::TemporaryFolder folder;
  EXPECT_THROW(make_movie(folder.path() / "a.mp4", folder.path(), 25), core::InputError);
  write_frames(folder.path(), 1);
  EXPECT_THROW(make_movie(folder.path() / "a.mp4", folder.path(), 0), core::InputError);
  EXPECT_THROW(make_movie(folder.path() / "a.mp4", folder.path(), 25, folder.path() / "no.wav"),
               core::InputError);
}

}  // namespace
}  // namespace carillon::render
