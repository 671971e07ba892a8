#pragma once

#include <filesystem>
#include <string>

namespace carillon::render {

/// Frames of a movie in a folder: frame_00000.png, frame_00001.png, ...
std::filesystem::path frame_path(const std::filesystem::path& folder, int number);

struct MovieResult {
  bool made = false;
  std::string message;  ///< why not, and what to do; empty when it was made
};

/// Joins frames to an MP4 (H.264, and AAC when there is sound) by the program ffmpeg, in one thread
/// and without dates or names, so that the same frames give the same bytes. Where there is no
/// ffmpeg on the PATH, or it fails, the frames stay and the message says so.
/// @param sound  a WAV file that starts with the first frame; empty: none
/// @throws InputError    frames per second that are not positive, no first frame, no such sound
/// @throws StorageError  a program cannot be started
MovieResult make_movie(const std::filesystem::path& movie, const std::filesystem::path& frames,
                       double frames_per_second, const std::filesystem::path& sound = {});

}  // namespace carillon::render
