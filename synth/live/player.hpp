#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "synth/live/mailbox.hpp"
#include "synth/modal/streaming_renderer.hpp"

namespace carillon::synth::live {

/// What happens at a time: a strike, other values of a body's modes, or the end.
struct Event {
  std::optional<double> time;  ///< [s] since the first sample; none: with the next block
  std::unique_ptr<modal::StreamedStrike> strike;
  std::unique_ptr<modal::StreamedChange> change;
  bool stop = false;
  Event* next = nullptr;
};

/// What has been played, as any thread may ask for it.
struct Played {
  std::uint64_t samples = 0;  ///< of each row
  std::uint64_t events = 0;   ///< that have begun, or wait within the renderer for their time
  std::uint64_t late = 0;     ///< of them: their time was over when they came
  double latest = 0;          ///< by how much, at the most [s]
  std::uint64_t voices = 0;   ///< partials that ring, and what is to come yet
  bool stopped = false;
};

/// Bodies that are played: events come from any threads, one thread asks for samples. That thread
/// neither allocates nor locks nor waits in play(): events bring all the memory that they need, the
/// way in and out is a Mailbox, and what is done with is freed by those who send. (A strike of a
/// sampled force allocates.)
class Player {
 public:
  /// @throws InputError  as StreamingRenderer
  Player(std::size_t rows, double sample_rate, double gain = 1);

  /// Before there are threads that play.
  /// @throws InputError  as StreamingRenderer
  std::size_t add_body(std::span<const double> eigenvalues, std::span<const double> decay_rates,
                       const modal::Readout& readout);

  /// For any thread: a strike, other values and the end; the time as Event::time.
  /// @throws InputError  as StreamingRenderer, or a time that is negative, not finite or years away
  void strike(std::size_t body, const Eigen::VectorXd& excitation, const modal::ContactForce& force,
              std::optional<double> time = {});
  void change(std::size_t body, std::span<const double> eigenvalues,
              std::span<const double> decay_rates, std::optional<double> time = {});
  void stop(std::optional<double> time = {});

  /// For one thread: the next samples, a frame of all rows after the other, as many as fit.
  void play(std::span<float> frames) noexcept;

  Played played() const;
  std::size_t rows() const { return rows_; }
  double sample_rate() const { return sample_rate_; }

 private:
  void send(std::unique_ptr<Event> event);
  void begin(std::unique_ptr<Event> event);

  static constexpr std::size_t block = modal::block_size;
  std::size_t rows_;
  double sample_rate_;
  double gain_;
  modal::StreamingRenderer renderer_;
  std::vector<float> samples_;  ///< of a block, row by row
  Mailbox<Event> inbox_, done_;
  Mailbox<modal::StreamedStrike> done_strikes_;
  Mailbox<modal::StreamedChange> done_changes_;
  std::uint64_t stop_at_ = UINT64_MAX;  ///< sample
  std::atomic<std::uint64_t> position_ = 0, events_ = 0, late_ = 0, voices_ = 0, sent_ = 0;
  std::atomic<double> latest_ = 0;
  std::atomic<bool> stopped_ = false;
};

}  // namespace carillon::synth::live
