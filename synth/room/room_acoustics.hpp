#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <string>

namespace carillon::synth::room {

/// Octave bands of rooms. The lowest reaches down to 0 Hz and the highest up to half the sample
/// rate; bands that begin above it do not exist at that rate.
inline constexpr std::size_t octave_count = 8;
inline constexpr std::array<double, octave_count> octave_centres = {125,  250,  500,  1000, 2000,
                                                                    4000, 8000, 16000};  ///< [Hz]
using OctaveValues = std::array<double, octave_count>;

/// Values of all octaves from 6 to 8 that begin at 125 Hz: the last holds for those above.
/// @throws InputError  another number of values
OctaveValues octaves_of(std::span<const double> values);

/// Edges of an octave band without the two extensions: centre / sqrt(2), centre * sqrt(2) [Hz].
double lower_edge(std::size_t octave);
double upper_edge(std::size_t octave);
/// Bands that begin below half the sample rate.
std::size_t octaves_below_nyquist(double sample_rate);

/// Air of a room, at 1013.25 hPa.
struct Air {
  double temperature = 20;  ///< [degrees C], -20 to 50
  double humidity = 0.5;    ///< relative, 0 to 1
  bool operator==(const Air&) const = default;
};

/// 343 m/s at 20 degrees C (speed_of_sound, as elsewhere), with the square root of the temperature.
/// @throws InputError  air outside the limits above
double sound_speed(const Air& air);

/// Energy that air takes from a plane wave: intensity ~ exp(-m x), m in 1/m. ISO 9613-1:1993,
/// eqs. 3 to 6; its attenuation in dB/m is m 10 log10(e).
/// @throws InputError  air outside the limits above
double air_absorption(double frequency, const Air& air);
OctaveValues air_absorption(const Air& air);  ///< at the octaves' centres

/// Walls of a shoebox room: at x = 0, x = L_x, y = 0, y = L_y, z = 0 (floor), z = L_z (ceiling).
inline constexpr std::size_t wall_count = 6;
inline constexpr std::array<const char*, wall_count> wall_names = {"x0", "x1",    "y0",
                                                                   "y1", "floor", "ceiling"};
using WallAbsorption =
    std::array<OctaveValues, wall_count>;  ///< fraction of energy not reflected, 0 to 1

/// One absorption on all walls.
WallAbsorption same_on_all_walls(const OctaveValues& absorption);

/// Mean of the walls' absorption by area.
/// @throws InputError  a size that is not positive and finite, absorption outside 0 to 1
OctaveValues mean_absorption(const Eigen::Vector3d& size, const WallAbsorption& walls);

/// Reverberation times [s] with air by Eyring: T = (24 ln 10 / c) V / (A + 4 m V) with
/// A = -S ln(1 - a), 0 s where a is 1. Air absorption shortens them (Kuttruff, Room Acoustics, 6th
/// ed., eqs. 5.24 to 5.26).
/// @param size        of the room [m]
/// @param absorption  mean absorption of the walls, 0 to 1
/// @throws InputError  a size that is not positive and finite, absorption outside 0 to 1, air
OctaveValues eyring(const Eigen::Vector3d& size, const OctaveValues& absorption, const Air& air);

/// Highest mean absorption that a prescribed reverberation time may ask for: beyond it, a change of
/// the time by a third would be one of the absorption by less than 0.01.
inline constexpr double highest_absorption = 0.99;

/// Reverberation times [s] a room can be given in one octave: from highest_absorption (low) to
/// walls that absorb nothing, air alone (high).
struct ReverberationLimits {
  double low;
  double high;
};
ReverberationLimits reverberation_limits(const Eigen::Vector3d& size, std::size_t octave,
                                         const Air& air);

/// Mean absorption that gives reverberation times by Eyring's formula.
/// @param times  [s]
/// @param octaves  how many bands count; the others get the last one's absorption
/// @throws InputError  a time outside the limits; names every such band and its limits
OctaveValues absorption_for(const Eigen::Vector3d& size, const OctaveValues& times, const Air& air,
                            std::size_t octaves = octave_count);

/// "5 x 4 x 3 m".
std::string size_text(const Eigen::Vector3d& size);

/// @throws InputError  unless all three sides are within 1e-6 and 1e6 m
void check_room_size(const Eigen::Vector3d& size);

}  // namespace carillon::synth::room
