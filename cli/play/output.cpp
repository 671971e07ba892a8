#include "cli/play/output.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <functional>
#include <span>
#include <thread>

#include "cli/play/interrupt.hpp"
#include "core/error.hpp"
#include "core/files.hpp"

namespace carillon::cli::play {

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

double processor_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// @return false when nobody reads any more, or a signal came
bool write_all(int stream, std::span<const std::byte> bytes, bool& closed) {
  while (!bytes.empty()) {
    if (Interrupts::signal() != 0) return false;
    pollfd ready{stream, POLLOUT, 0};
    if (::poll(&ready, 1, 50) <= 0) continue;
    // What fits a pipe that has room does not wait.
    const ssize_t sent = ::write(stream, bytes.data(), std::min<std::size_t>(bytes.size(), 4096));
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) {
      if (errno != EPIPE) throw core::FileError("standard output cannot be written to");
      closed = true;
      return false;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
  return true;
}

bool ended(synth::live::Player& player, const Pace& pace, const EventReader* events) {
  const synth::live::Played played = player.played();
  if (played.stopped) return true;
  return pace.ends_silent && (events == nullptr || events->ended()) && played.voices == 0;
}

/// Plays block by block and hands each on.
/// @param put  a block; false: it was the last
Heard play_blocks(synth::live::Player& player, const Pace& pace, EventReader* events,
                  const std::function<bool(std::span<const float>)>& put) {
  Heard heard;
  const double rate = player.sample_rate();
  const auto last =
      pace.seconds > 0 ? static_cast<std::uint64_t>(std::llround(pace.seconds * rate)) : UINT64_MAX;
  std::vector<float> frames;
  if (events != nullptr && pace.clock) events->wait_for(0.5, 0.25);
  Clock::time_point start = Clock::now();
  for (std::uint64_t done = 0; done < last && Interrupts::signal() == 0;) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(pace.block, last - done));
    const double begin = static_cast<double>(done) / rate;
    if (events != nullptr) {
      events->played(begin);
      const double end = begin + static_cast<double>(count) / rate;
      while (!pace.clock && Interrupts::signal() == 0 && !events->wait_for(end, 0.05)) continue;
    }
    if (ended(player, pace, events)) break;
    if (pace.clock) {
      std::this_thread::sleep_until(start +
                                    std::chrono::duration_cast<Clock::duration>(Seconds(begin)));
    }
    frames.resize(count * player.rows());
    const double before = processor_time();
    player.play(frames);
    heard.processor_seconds += processor_time() - before;
    heard.voice_samples += static_cast<double>(player.played().voices * count);
    if (!put(frames)) break;
    done += count;
    if (!pace.clock) continue;
    const double late = Seconds(Clock::now() - start).count() - begin - pace.latency;
    if (late > 0) {
      ++heard.dropouts;
      heard.latest = std::max(heard.latest, late);
      heard.behind += late;
      start += std::chrono::duration_cast<Clock::duration>(Seconds(late));
    }
  }
  return heard;
}

}  // namespace

Heard play_to_stream(synth::live::Player& player, int stream, const Pace& pace,
                     EventReader* events) {
  bool closed = false;
  Heard heard = play_blocks(player, pace, events, [&](std::span<const float> frames) {
    if (pace.format == core::SampleFormat::float32) {
      return write_all(stream, std::as_bytes(frames), closed);
    }
    const std::vector<std::int16_t> whole = core::to_int16(frames);
    return write_all(stream, std::as_bytes(std::span(whole)), closed);
  });
  heard.reader_closed = closed;
  return heard;
}

Heard play_to_file(synth::live::Player& player, const std::string& path, const Pace& pace,
                   EventReader* events) {
  core::AudioClip clip;
  clip.channels = static_cast<int>(player.rows());
  clip.sample_rate = static_cast<int>(std::lround(player.sample_rate()));
  const Heard heard = play_blocks(player, pace, events, [&](std::span<const float> frames) {
    clip.samples.insert(clip.samples.end(), frames.begin(), frames.end());
    return true;
  });
  core::write_durably(
      path, [&](const std::filesystem::path& file) { core::write_wav(file, clip, pace.format); });
  return heard;
}

void follow(synth::live::Player& player, const Pace& pace, EventReader* events) {
  while (Interrupts::signal() == 0 && !ended(player, pace, events)) {
    const double time = static_cast<double>(player.played().samples) / player.sample_rate();
    if (events != nullptr) events->played(time);
    if (pace.seconds > 0 && time >= pace.seconds) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

}  // namespace carillon::cli::play
