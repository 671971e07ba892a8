#include "render/movie.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <vector>

#include "core/child_process.hpp"
#include "core/error.hpp"

namespace carillon::render {
namespace {

namespace fs = std::filesystem;

constexpr double longest_seconds = 3600;

/// The program of this name that a shell would start; empty: none.
fs::path on_path(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path program = fs::path(folder.empty() ? "." : folder) / name;
    std::error_code ignored;
    if (fs::is_regular_file(program, ignored) && access(program.c_str(), X_OK) == 0) return program;
  }
  return {};
}

/// A name as ffmpeg takes it, whatever is in it.
std::string name_of(const fs::path& path) {
  return "file:" + fs::absolute(path).string();
}

/// The frames' pattern, in which ffmpeg reads every other % of the folder's name as itself.
std::string pattern_of(const fs::path& frames) {
  std::string name;
  for (const char letter : name_of(frames))
    name += letter == '%' ? std::string("%%") : std::string(1, letter);
  return name + "/frame_%05d.png";
}

}  // namespace

fs::path frame_path(const fs::path& folder, int number) {
  return folder / fmt::format("frame_{:05}.png", number);
}

MovieResult make_movie(const fs::path& movie, const fs::path& frames, double frames_per_second,
                       const fs::path& sound) {
  if (!(frames_per_second > 0) || !std::isfinite(frames_per_second)) {
    throw core::InputError(
        fmt::format("a movie of {} frames per second: must be positive", frames_per_second));
  }
  if (!fs::exists(frame_path(frames, 0))) {
    throw core::InputError(fmt::format("{}: no such file, so no frame to begin a movie with",
                                       frame_path(frames, 0).string()));
  }
  if (!sound.empty() && !fs::exists(sound)) {
    throw core::InputError(fmt::format("{}: no such file", sound.string()));
  }
  const fs::path ffmpeg = on_path("ffmpeg");
  if (ffmpeg.empty()) {
    return {false, "no ffmpeg on the PATH (Debian: apt-get install ffmpeg)"};
  }
  fs::path unfinished = movie;
  unfinished += ".part";
  std::vector<std::string> words = {"-nostdin",
                                    "-hide_banner",
                                    "-loglevel",
                                    "error",
                                    "-y",
                                    "-fflags",
                                    "+bitexact",
                                    "-framerate",
                                    fmt::format("{}", frames_per_second),
                                    "-i",
                                    pattern_of(frames)};
  if (!sound.empty()) words.insert(words.end(), {"-i", name_of(sound)});
  // Players want an even number of pixels a side, with colour at half the resolution.
  words.insert(words.end(), {"-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf",
                             "18", "-pix_fmt", "yuv420p"});
  if (!sound.empty()) words.insert(words.end(), {"-c:a", "aac", "-b:a", "192k"});
  words.insert(words.end(), {"-threads", "1", "-flags:v", "+bitexact", "-flags:a", "+bitexact",
                             "-fflags", "+bitexact", "-map_metadata", "-1", "-movflags",
                             "+faststart", "-f", "mp4", name_of(unfinished)});
  const core::ChildExit end = core::run_child(ffmpeg, words, longest_seconds);
  std::error_code ignored;
  if (end.code != 0 || end.signal != 0 || end.timed_out) {
    fs::remove(unfinished, ignored);
    return {false, fmt::format("{} could not make it: {}", ffmpeg.string(), end.output)};
  }
  fs::rename(unfinished, movie);
  return {true, {}};
}

}  // namespace carillon::render
