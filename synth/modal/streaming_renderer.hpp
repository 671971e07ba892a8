#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "synth/modal/near_critical.hpp"
#include "synth/modal/owned_list.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/modal/row_response.hpp"

namespace carillon::synth::modal {

/// Longest contact of a streamed strike in samples: 227 s at 44.1 kHz, 80 MB for each row.
inline constexpr double longest_contact = 1e7;

/// A strike with all the memory that it needs; what is in it is the renderer's own business.
struct StreamedStrike {
  struct InRow {
    long double start = 0, stop = 0;            ///< of the contact as the row hears it [samples]
    std::uint64_t first = 0, free = 0;          ///< first samples not before them
    long double first_time = 0, free_time = 0;  ///< from them to these samples [s]
    bool begun = false, ended = false;
    const Resonances* of = nullptr;  ///< what the response is one of
    RowResponse response;
    Rotation turn;  ///< of the force's own frequency
  };
  std::size_t body = 0;
  Eigen::VectorXd excitation;
  ContactForce force;
  std::vector<InRow> rows;
  std::size_t rows_left = 0;  ///< that it has not ended in
  StreamedStrike* next = nullptr;
};

/// Other eigenvalues and decay rates of a body's modes, from some time on; likewise.
struct StreamedChange {
  struct InRow {
    std::vector<Voice> voices;
    std::vector<NearCritical> near_critical;
  };
  std::size_t body = 0;
  long double time = 0;  ///< before each row's time of flight [samples]
  Resonances resonances;
  std::vector<ModalMotion> motions;
  std::vector<InRow> rows;  ///< what rings is built in, and exchanged with what rang
  StreamedChange* next = nullptr;
};

/// Many bodies that are struck at any time, heard together in blocks of samples of any size.
///
/// A strike adds to the values its body's modes have, as their motion is linear: state does not
/// grow with the number of strikes. What comes out is what synthesize() gives for each strike,
/// delayed and added up, to -120 dB of the peak since the last strike on that body (what ends early
/// included). Modes that have decayed are taken out: silence costs nothing but a look at each body
/// that rings. Once strikes have been as long and as many at a time as they will be, render()
/// allocates nothing, and strike() only for a sampled force.
///
/// A body's modes may change while it sounds, as when a hand is laid on it: displacement and
/// velocity of every mode go on without a step, q'' + 2 d(t) q' + lambda(t) q = f holds through the
/// change, at any fraction of a sample, also while a force acts.
///
/// For a thread that must not wait, another one prepares: prepare_strike() and prepare_change()
/// allocate and may be called while the first one renders; begin() and render() then allocate
/// nothing (but for sampled forces), and what is done with is taken away by take_ended_strike() and
/// take_ended_change(), to be freed elsewhere.
class StreamingRenderer {
 public:
  /// @param rows  outputs (listeners), the same for all bodies
  /// @throws InputError  no rows, a sample rate that cannot be
  StreamingRenderer(std::size_t rows, double sample_rate);
  // Voices point at rotations of their body, which move along but would not be copied along.
  StreamingRenderer(const StreamingRenderer&) = delete;
  StreamingRenderer& operator=(const StreamingRenderer&) = delete;
  StreamingRenderer(StreamingRenderer&&) = default;
  StreamingRenderer& operator=(StreamingRenderer&&) = default;
  ~StreamingRenderer() = default;

  /// Modes at or above Nyquist are left out (modes_above_nyquist() counts them).
  /// @return the body's number
  /// @throws InputError  sizes that do not match, values that are negative or not finite
  std::size_t add_body(std::span<const double> eigenvalues, std::span<const double> decay_rates,
                       const Readout& readout);

  /// A strike `delay` seconds after the next sample (any fraction of one); each row hears it after
  /// its own time of flight.
  /// @param excitation  phi . impulse of the body's modes [N s kg^-1/2]
  /// @throws InputError  no such body, sizes, values that are not finite, a negative delay or one
  ///                     of a year, a contact longer than longest_contact
  void strike(std::size_t body, const Eigen::VectorXd& excitation, const ContactForce& force,
              double delay = 0);

  /// The body's modes have these values from `delay` seconds after the next sample on; each row
  /// hears it after its own time of flight. Values of a mode at or above Nyquist silence it.
  /// @throws InputError  no such body, as many values as it has not, values that are negative or
  ///                     not finite, a delay as strike()
  void change(std::size_t body, std::span<const double> eigenvalues,
              std::span<const double> decay_rates, double delay = 0);

  /// What strike() and change() do before they begin.
  /// @throws InputError  as these
  std::unique_ptr<StreamedStrike> prepare_strike(std::size_t body,
                                                 const Eigen::VectorXd& excitation,
                                                 const ContactForce& force) const;
  std::unique_ptr<StreamedChange> prepare_change(std::size_t body,
                                                 std::span<const double> eigenvalues,
                                                 std::span<const double> decay_rates) const;
  /// What they do then.
  /// @throws InputError  a delay that is negative or one of a year
  void begin(std::unique_ptr<StreamedStrike> strike, double delay = 0);
  void begin(std::unique_ptr<StreamedChange> change, double delay = 0);

  /// A strike whose contact is over in every row, or values that no row has any more; null: none.
  std::unique_ptr<StreamedStrike> take_ended_strike() { return ended_strikes_.pop_front(); }
  std::unique_ptr<StreamedChange> take_ended_change() { return ended_changes_.pop_front(); }

  /// The next samples, rows one after the other; their number is a multiple of the rows.
  void render(std::span<float> samples);

  std::uint64_t position() const { return position_; }  ///< samples of a row rendered so far
  std::size_t voices() const;                           ///< partials that ring
  std::size_t contacts() const;  ///< strikes that have not ended, or not begun

 private:
  struct Row {
    StreamedChange* values = nullptr;  ///< that its modes have
    std::vector<Voice> voices;
    std::vector<NearCritical> near_critical;
    double peak = 0;  ///< since the last strike's begin
    std::uint64_t next_check = 0;
  };
  struct Body {
    Body() = default;
    Body(const Body&) = delete;
    Body& operator=(const Body&) = delete;
    Body(Body&&) = default;
    Body& operator=(Body&&) = default;
    ~Body() = default;
    std::size_t modes = 0;
    Readout readout;
    OwnedList<StreamedChange> values;  ///< by time; the first ones are those that rows have
    OwnedList<StreamedStrike> strikes;
    std::vector<Row> rows;
  };

  const Body& checked_body(std::size_t body) const;
  void fill(StreamedStrike& strike, std::size_t body, const Eigen::VectorXd& excitation,
            const ContactForce& force) const;
  void answer(const Body& body, std::size_t row, StreamedStrike& strike) const;
  void render_row(Body& body, std::size_t row, std::size_t count);
  std::uint64_t follow_strikes(Body& body, std::size_t row, std::uint64_t now, long double before);
  void change_row(Body& body, std::size_t row, std::uint64_t now, long double at);
  void render_stretch(Body& body, std::size_t row, std::uint64_t begin, std::size_t offset,
                      std::size_t count);
  void take_ended(Body& body);

  double sample_rate_;
  std::size_t rows_;
  std::uint64_t position_ = 0;
  std::vector<Body> bodies_;
  OwnedList<StreamedStrike> ended_strikes_;
  OwnedList<StreamedChange> ended_changes_;
  SampleBlock block_{};  ///< of one body
  SampleBlock sum_{};    ///< of all
};

/// Samples of each row, as synthesize() gives them, of one strike after another on the same body.
/// @param times  of the strikes [s], any order
/// @throws InputError  as synthesize(), or a time that is negative or not finite
std::vector<float> synthesize_strikes(const RingDown& rings, const ContactForce& force,
                                      std::span<const double> times, double sample_rate,
                                      std::size_t count);

}  // namespace carillon::synth::modal
