#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/material/struck_modes.hpp"
#include "solvers/modes/modes.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/radiation/modal_pressure.hpp"

namespace carillon::eval::recorded_objects {

/// A strike as the model makes it: 1 N s into the surface. Of an ideal impulse a recording that was
/// deconvolved by the hammer's force is the answer.
struct ModelStrike {
  synth::modal::SurfacePoint point;
  Vec3 direction;                   ///< inward along the normal
  synth::modal::Listener listener;  ///< [m], in the object's coordinates
  double contact_time = 0;          ///< of a raised cosine [s]; 0: an ideal impulse
};

/// An object of one specific modulus as the microphones of some strikes hear it.
struct HeardObject {
  solvers::modes::Modes modes;
  double specific_modulus = 0;  ///< E / density [m^2/s^2]
  /// Pressure at the listener of each strike; none: the acceleration of the struck point instead,
  /// as a contact microphone takes it.
  std::optional<synth::radiation::ModalPressure> pressure;
  std::vector<double> radiated;  ///< decay rate of each mode by radiation [1/s]; empty: none
  std::size_t doubtful = 0;      ///< modes whose radiation is not to be trusted
};

/// @param modes   of the same object with the specific modulus `assumed`
/// @param cache   folder of what is dear to compute; empty: none
/// @throws InputError  a listener inside the object or too near to it
HeardObject hear_object(const solvers::modes::Modes& modes, double assumed, double specific_modulus,
                        const std::vector<ModelStrike>& strikes, bool radiation,
                        const std::filesystem::path& cache);

/// Leaves of the strikes, and of what is heard of them, those whose numbers are in `kept`.
/// @param kept  ascending
void keep_strikes(const std::vector<std::size_t>& kept, std::vector<ModelStrike>& strikes,
                  HeardObject& object);

/// Modes as strike number `number` strikes them and its listener hears them.
material::StruckModes struck_by(const HeardObject& object, const std::vector<ModelStrike>& strikes,
                                std::size_t number);

/// When the first sound of a strike comes to its listener [s].
double arrival(const HeardObject& object, const std::vector<ModelStrike>& strikes,
               std::size_t number);

/// The model's own recording of a strike, sample 0 when it begins [Pa per N s, or m/s^2 per N s].
std::vector<double> synthetic_recording(const HeardObject& object,
                                        const std::vector<ModelStrike>& strikes, std::size_t number,
                                        const synth::damping::DampingModel& damping,
                                        double sample_rate, std::size_t count);

}  // namespace carillon::eval::recorded_objects
