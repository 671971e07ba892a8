#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "synth/modal/near_critical.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/modal/row_response.hpp"

namespace carillon::synth::modal {

/// Longest contact of a streamed strike in samples: 227 s at 44.1 kHz, 80 MB for each row.
inline constexpr double longest_contact = 1e7;

/// Many bodies that are struck at any time, heard together in blocks of samples of any size.
///
/// A strike adds to the values its body's modes have, as their motion is linear: state does not
/// grow with the number of strikes. What comes out is what synthesize() gives for each strike,
/// delayed and added up, to -120 dB of the peak since the last strike on that body (what ends early
/// included). Modes that have decayed are taken out: silence costs nothing but a look at each body
/// that rings. Once strikes have been as long and as many at a time as they will be, render()
/// allocates nothing, and strike() only for a sampled force.
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

  /// The next samples, rows one after the other; their number is a multiple of the rows.
  void render(std::span<float> samples);

  std::uint64_t position() const { return position_; }  ///< samples of a row rendered so far
  std::size_t voices() const;                           ///< partials that ring

 private:
  /// One strike in one row, until its contact is over.
  struct Strike {
    std::uint64_t first = 0, free = 0;  ///< samples
    bool begun = false;
    RowResponse response;
    Rotation turn;  ///< of the force's own frequency
  };
  struct Row {
    std::vector<Voice> voices;
    std::vector<NearCritical> near_critical;
    std::vector<Strike> strikes;  ///< the first `waiting` are in use, the others keep their memory
    std::size_t waiting = 0;
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
    Resonances resonances;
    Readout readout;
    std::vector<Row> rows;
  };

  void render_row(const Body& body, Row& row, std::size_t count);
  void render_stretch(const Body& body, Row& row, std::uint64_t begin, std::size_t offset,
                      std::size_t count);

  double sample_rate_;
  std::size_t rows_;
  std::uint64_t position_ = 0;
  std::vector<Body> bodies_;
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
