#pragma once

#include <complex>
#include <cstddef>
#include <optional>
#include <vector>

#include "synth/modal/modal_response.hpp"
#include "synth/modal/mode_norms.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/modal/sampled_force.hpp"

namespace carillon::synth::modal {

/// Over which the ear integrates a tone's energy [s] (Zwicker and Fastl 2007, section 4.4).
inline constexpr double kIntegrationTime = 0.2;

/// What kind of motion a mode has: it rings, it does not oscillate or nearly so, or it lies at or
/// above half the sample rate and is not heard at all.
enum class MotionKind { ringing, other, above_band };

/// A mode of a ring-down under a strike's force, as thrift judges it.
struct RingingMode {
  MotionKind kind = MotionKind::other;
  bool drifts = false;  ///< neither stiffness nor damping
  std::optional<ModalResponse> pulse;
  std::optional<SampledResponse> sampled;
  double frequency = 0;  ///< [Hz], damped
  double bark = 0;
  std::complex<double> pole;

  ModalMotion during(double t) const { return sampled ? sampled->at(t) : pulse->during_contact(t); }
};

/// A mode as one row hears it.
struct HeardMode {
  Weights weights;
  std::complex<double> amplitude;  ///< of the free decay at the contact's end
  double loudness = 0;             ///< mean square over the integration time, after the contact
  std::vector<double> contact;     ///< samples during the contact, once they are asked for
  double contact_peak = 0;         ///< their largest magnitude
  double contact_energy = 0;       ///< sum of their squares
};

/// Instants of a row's samples.
struct RowTimes {
  double delay;
  std::size_t first;  ///< sample that hears the contact
  std::size_t free;   ///< first sample after it
  double offset;      ///< its time after the contact's end [s]
};

std::vector<RingingMode> ringing_modes(const RingDown& rings, const ContactForce& force,
                                       double sample_rate);

RowTimes row_times(double delay, const ContactForce& force, double sample_rate, std::size_t count);

/// @param duration  of the contact [s]
HeardMode hear_mode(const RingingMode& mode, const Weights& weights, double duration);

/// Fills in the samples during the contact, once.
void hear_contact(const RingingMode& mode, const RowTimes& times, double duration,
                  double sample_rate, HeardMode& heard);

/// The free decay from the first sample after the contact on.
SampledPartial partial_of(const RingingMode& mode, const HeardMode& heard, const RowTimes& times,
                          double sample_rate);

}  // namespace carillon::synth::modal
