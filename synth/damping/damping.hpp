#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/fault.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::synth::damping {

/// How the damping coefficient c of a mode depends on its eigenvalue lambda = omega_n^2
/// [rad^2/s^2]: q'' + c q' + lambda q = F, decay rate d = c / 2. All parameters alpha are those of
/// c, in SI units.
enum class DampingKind {
  rayleigh,   ///< c = alpha1 + alpha2 lambda (Sterling 2019, eq. 2.11)
  caughey,    ///< c = alpha1 + alpha2 lambda + alpha3 lambda^2 + ... (eq. 2.12, power omega^(2 j))
  power,      ///< c = alpha1 lambda^alpha2 (eq. 3.4)
  hybrid,     ///< c = alpha1 + alpha2 lambda^alpha3 (eq. 4.1)
  expression  ///< any formula of lambda, omega = sqrt(lambda), f = omega / (2 pi) and the alphas
};

/// A damping model: plain data. The default is a material without damping.
struct DampingModel {
  DampingKind kind = DampingKind::rayleigh;
  std::vector<double> parameters = {0, 0};  ///< alpha1, alpha2, ...
  std::string expression;                   ///< of DampingKind::expression, else empty
  bool operator==(const DampingModel&) const = default;
};

DampingModel rayleigh_damping(double alpha1, double alpha2);

/// The model whose c is everywhere `factor` times as large, of the same kind.
DampingModel scaled(DampingModel model, double factor);

/// What every kind is called and looks like, for lists and messages.
struct DampingForm {
  DampingKind kind;
  const char* name;
  const char* formula;      ///< "c = alpha1 + alpha2 lambda"
  const char* description;  ///< for whom, and from which paper
  std::size_t min_parameters;
  std::size_t max_parameters;
  std::vector<std::string> units;  ///< of alpha1, alpha2, ...; those of a series go on as s^(2k-3)
};
const std::vector<DampingForm>& damping_forms();
const DampingForm& form_of(DampingKind kind);
/// Unit of a parameter, counted from 0: "1/s", "s", "s^3", "s^(2 alpha2 - 1)", "1"; "SI" for those
/// of an expression.
std::string parameter_unit(DampingKind kind, std::size_t parameter);
/// "alpha1" for 0.
std::string parameter_name(std::size_t parameter);
/// The formula with its numbers: "c = 3.9 + 5.2e-09 lambda^1.027".
std::string formula_of(const DampingModel& model);

/// Rules: the number of parameters; all finite; none negative that would make Rayleigh's, the
/// power law's or the hybrid's damping negative at low or high frequencies (a Caughey series and an
/// expression may be negative somewhere: see decay_rates()); an expression that can be read. The
/// key of what breaks them is that of a parameter, or "damping".
std::optional<core::Fault> damping_fault(const DampingModel& model);
/// @throws InputError  the model breaks a rule
void check_damping(const DampingModel& model);

/// Whether c is zero everywhere (never said of an expression).
bool is_undamped(const DampingModel& model);

/// c(lambda) [1/s] for lambda >= 0 as a function that can be asked often (an expression is read
/// once). It says what the formula says: that may be negative or not finite. Not to be shared
/// between threads.
/// @throws InputError  the model breaks a rule
std::function<double(double)> damping_function(const DampingModel& model);

/// c(lambda) [1/s] of every eigenvalue, n values, as damping_function() gives it.
std::vector<double> damping_coefficients(const DampingModel& model, std::span<const double> lambda);

/// Frequencies [Hz] between which a model's damping is negative.
struct NegativeRange {
  double low = 0;
  double high = 0;
};
/// Where in a band c < 0. Looked for at 4,096 frequencies on a logarithmic scale, ends then
/// bisected to 1e-9; what is narrower than a step (0.17 % of the frequency from 20 Hz to 20 kHz)
/// can be missed here, but not by decay_rates(), which asks at the modes.
/// @throws InputError  0 < low < high does not hold, or the model breaks a rule
std::vector<NegativeRange> negative_ranges(const DampingModel& model, double low_hz,
                                           double high_hz);

/// Decay rates where models may have been negative.
struct DecayRates {
  std::vector<double> values;         ///< d >= 0 [1/s], one per mode; 0 for the modes below
  std::vector<std::size_t> negative;  ///< modes that the models would let grow, ascending
};

/// Decay rates d = c / 2 [1/s] of every mode; those that would be negative are set to zero and
/// listed.
///
/// A body of one region has c = c(lambda) exactly. In a body of several regions r with models c_r,
/// c_r(0) acts like a mass-proportional term and the rest like a stiffness-proportional one:
/// c_i = sum over r of c_r(0) kinetic_fraction + (c_r(lambda_i) - c_r(0)) strain_fraction, which is
/// exact for Rayleigh damping as far as the damping stays diagonal. Where c_r(0) is not finite (a
/// power law with a negative exponent, a logarithm), c_r(lambda_i) is weighed by the mean of both
/// shares: the region's fraction of the mode's energy over a cycle.
///
/// Modes whose decay rates came with them keep these, whatever the models say.
///
/// @param regions  one for each region of the modes
/// @throws InputError  the number of regions, a model that breaks a rule, or a rate that is not
///                     finite (names the frequency)
DecayRates clamped_decay_rates(const solvers::modes::Modes& modes,
                               std::span<const DampingModel> regions);

/// The same, where negative damping is an error.
/// @throws InputError  also for negative damping; names the frequencies
std::vector<double> decay_rates(const solvers::modes::Modes& modes,
                                std::span<const DampingModel> regions);

/// Which modes the models would let grow, and between which frequencies [Hz]; for one region, also
/// where its formula is negative between the first and the last mode.
std::string describe_negative(const solvers::modes::Modes& modes,
                              std::span<const DampingModel> regions,
                              std::span<const std::size_t> negative);

}  // namespace carillon::synth::damping
