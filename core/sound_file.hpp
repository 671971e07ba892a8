#pragma once

#include <sndfile.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>

#include "core/handle.hpp"

namespace carillon::core {

/// An audio file that is open for reading.
///
/// Headers are mended on the way, the file stays as it is: BW64 is read as RF64, whose fields it
/// shares (ITU-R BS.2088), and a WAV file whose data chunk has size 0 with samples after it, as a
/// recorder leaves it that was cut off, to its end.
class SoundFile {
 public:
  /// @throws FileError  no such file, not of sound, or damaged: with the reason and what to do
  explicit SoundFile(const std::filesystem::path& path);
  SoundFile(const SoundFile&) = delete;
  SoundFile& operator=(const SoundFile&) = delete;

  const SF_INFO& info() const { return info_; }
  SNDFILE* get() { return file_.get(); }

 private:
  struct Source {
    std::ifstream file;
    std::map<std::int64_t, char> changed;  ///< bytes that are read in place of the file's
    std::int64_t size = 0;
  };
  static void close(SNDFILE** file) { sf_close(*file); }

  Source source_;
  SF_INFO info_{};
  Handle<SNDFILE*, close, nullptr> file_;
};

/// Why libsndfile has given up, in place of its own words.
/// @param code  of sf_error()
const char* sound_fault(int code);

}  // namespace carillon::core
