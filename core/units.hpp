#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace carillon::core {

/// What a number measures. Values are held in the SI unit named here.
enum class Dimension {
  none,        ///< plain number; "%" is 0.01
  length,      ///< m: m, cm, mm, um, km, in
  time,        ///< s: s, ms, us, min, h
  frequency,   ///< Hz: Hz, kHz, MHz
  pressure,    ///< Pa: Pa, kPa, MPa, GPa
  density,     ///< kg/m^3: kg/m^3, kg/m3, g/cm^3, g/cm3
  mass,        ///< kg: kg, g, mg
  speed,       ///< m/s: m/s, mm/s, km/h
  angle,       ///< rad: rad, deg
  force,       ///< N: N, mN, kN
  impulse,     ///< N s: N s, N*s, Ns, mN s
  stiffness,   ///< N/m: N/m, kN/m, N/mm
  resistance,  ///< N s/m, of a damper: N s/m, N*s/m, Ns/m, kg/s
  memory,      ///< byte: B, KiB, MiB, GiB, kB, MB, GB
  level        ///< dB: dB, a ratio held as written; what it is a ratio of is the key's matter
};

/// Value of a text such as "0.12 m", "12 cm", "20 kHz" or "0.3" (SI assumed) in SI units.
/// @throws InputError  not a number, or a unit of another dimension; names the units that fit
double parse_quantity(std::string_view text, Dimension dimension);

/// [m] of a unit of length by its name: "mm", "cm", "m", "inch", ...
/// @throws InputError  no unit of length
double parse_unit_of_length(std::string_view name);

/// SI unit of a dimension, e.g. "m"; "1" for none.
std::string unit_name(Dimension dimension);

/// What a dimension is called, e.g. "length"; "plain number" for none.
std::string_view dimension_name(Dimension dimension);

/// Units of a dimension without blanks, e.g. "m", "cm", ...; "%" for none.
std::vector<std::string> unit_names(Dimension dimension);

/// The candidate nearest to `word` by edit distance, or "" when none is near enough to be a slip.
std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace carillon::core
