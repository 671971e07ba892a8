#include "synth/room/room_acoustics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/modal/readout.hpp"

namespace carillon::synth::room {

using core::InputError;

namespace {

void check_air(const Air& air) {
  if (!(air.temperature >= -20 && air.temperature <= 50)) {
    throw InputError(fmt::format("air of {} degrees C", air.temperature),
                     "ISO 9613-1 holds from -20 to 50 degrees C");
  }
  if (!(air.humidity >= 0 && air.humidity <= 1)) {
    throw InputError(fmt::format("a relative humidity of {}", air.humidity),
                     "it lies between 0 and 1 (0 % and 100 %)");
  }
}

void check_absorption(const OctaveValues& absorption) {
  for (std::size_t b = 0; b < octave_count; ++b) {
    if (!(absorption[b] >= 0 && absorption[b] <= 1)) {
      throw InputError(
          fmt::format("absorption {} in the octave of {} Hz", absorption[b], octave_centres[b]),
          "it is the fraction of energy that a wall does not reflect: 0 to 1");
    }
  }
}

double surface(const Eigen::Vector3d& size) {
  return 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
}

/// V / S, safe for rooms whose volume alone would underflow.
double volume_over_surface(const Eigen::Vector3d& size) {
  return 1 / (2 * (1 / size.x() + 1 / size.y() + 1 / size.z()));
}

/// T of an equivalent absorption per surface, -ln(1 - a), and the air's.
double reverberation(const Eigen::Vector3d& size, double per_surface, double m, double speed) {
  const double v_s = volume_over_surface(size);
  return 24 * std::numbers::ln10 / speed * v_s / (per_surface + 4 * m * v_s);
}

}  // namespace

OctaveValues octaves_of(std::span<const double> values) {
  if (values.size() < 6 || values.size() > octave_count) {
    throw InputError(
        fmt::format("one value, or 6 to 8 for the octaves from 125 Hz on, not {}", values.size()));
  }
  OctaveValues octaves{};
  for (std::size_t b = 0; b < octave_count; ++b)
    octaves[b] = values[std::min(b, values.size() - 1)];
  return octaves;
}

double lower_edge(std::size_t octave) {
  return octave_centres[octave] / std::numbers::sqrt2;
}

double upper_edge(std::size_t octave) {
  return octave_centres[octave] * std::numbers::sqrt2;
}

std::size_t octaves_below_nyquist(double sample_rate) {
  std::size_t count = 1;  // the lowest reaches down to 0 Hz
  while (count < octave_count && lower_edge(count) < sample_rate / 2) ++count;
  return count;
}

double sound_speed(const Air& air) {
  check_air(air);
  return modal::speed_of_sound * std::sqrt((air.temperature + 273.15) / 293.15);
}

double air_absorption(double frequency, const Air& air) {
  check_air(air);
  const double kelvin = air.temperature + 273.15;
  const double relative = kelvin / 293.15;
  // Annex B: saturation pressure over the reference pressure; eqs. 3 and 4: relaxation frequencies
  // of oxygen and nitrogen; eq. 5: attenuation. The ambient pressure is the reference pressure.
  const double saturation = std::pow(10, -6.8346 * std::pow(273.16 / kelvin, 1.261) + 4.6151);
  const double h = 100 * air.humidity * saturation;  // molar concentration of water [%]
  const double oxygen = 24 + 4.04e4 * h * (0.02 + h) / (0.391 + h);
  const double nitrogen =
      (9 + 280 * h * std::exp(-4.170 * (std::pow(relative, -1.0 / 3) - 1))) / std::sqrt(relative);
  const double f2 = frequency * frequency;
  const double amplitude =
      f2 * (1.84e-11 * std::sqrt(relative) +
            std::pow(relative, -2.5) *
                (0.01275 * std::exp(-2239.1 / kelvin) / (oxygen + f2 / oxygen) +
                 0.1068 * std::exp(-3352.0 / kelvin) / (nitrogen + f2 / nitrogen)));  // [Np/m]
  return 2 * amplitude;
}

OctaveValues air_absorption(const Air& air) {
  OctaveValues m;
  for (std::size_t b = 0; b < octave_count; ++b) m[b] = air_absorption(octave_centres[b], air);
  return m;
}

WallAbsorption same_on_all_walls(const OctaveValues& absorption) {
  WallAbsorption walls;
  walls.fill(absorption);
  return walls;
}

OctaveValues mean_absorption(const Eigen::Vector3d& size, const WallAbsorption& walls) {
  check_room_size(size);
  const std::array<double, 3> area = {size.y() * size.z(), size.z() * size.x(),
                                      size.x() * size.y()};
  for (const OctaveValues& wall : walls) check_absorption(wall);
  OctaveValues mean{};
  for (std::size_t b = 0; b < octave_count; ++b) {
    for (std::size_t w = 0; w < wall_count; ++w) mean[b] += area[w / 2] * walls[w][b];
    mean[b] = std::min(mean[b] / surface(size), 1.0);  // a rounding error above 1 is none
  }
  return mean;
}

OctaveValues eyring(const Eigen::Vector3d& size, const OctaveValues& absorption, const Air& air) {
  check_room_size(size);
  check_absorption(absorption);
  const double speed = sound_speed(air);
  const OctaveValues m = air_absorption(air);
  OctaveValues result;
  for (std::size_t b = 0; b < octave_count; ++b) {
    result[b] = reverberation(size, -std::log1p(-absorption[b]), m[b], speed);
  }
  return result;
}

ReverberationLimits reverberation_limits(const Eigen::Vector3d& size, std::size_t octave,
                                         const Air& air) {
  check_room_size(size);
  const double m = air_absorption(octave_centres[octave], air);
  const double speed = sound_speed(air);
  return {reverberation(size, -std::log1p(-highest_absorption), m, speed),
          reverberation(size, 0, m, speed)};
}

OctaveValues absorption_for(const Eigen::Vector3d& size, const OctaveValues& times, const Air& air,
                            std::size_t octaves) {
  OctaveValues absorption{};
  std::string impossible;
  for (std::size_t b = 0; b < octaves; ++b) {
    const ReverberationLimits limits = reverberation_limits(size, b, air);
    // A fraction of 1e-9 for what was computed from an absorption at a limit.
    if (!(times[b] >= limits.low * (1 - 1e-9) && times[b] <= limits.high * (1 + 1e-9))) {
      impossible += fmt::format(
          "{}{} Hz: {:.4g} s is {}", impossible.empty() ? "" : "; ", octave_centres[b], times[b],
          times[b] > limits.high
              ? fmt::format("longer than the {:.4g} s that air alone allows", limits.high)
              : fmt::format("not within {:.4g} s (absorption {}) and {:.4g} s (air alone)",
                            limits.low, highest_absorption, limits.high));
      continue;
    }
    const double v_s = volume_over_surface(size);
    const double m = air_absorption(octave_centres[b], air);
    const double per_surface =
        24 * std::numbers::ln10 * v_s / (sound_speed(air) * times[b]) - 4 * m * v_s;
    absorption[b] = std::clamp(-std::expm1(-per_surface), 0.0, highest_absorption);
  }
  if (!impossible.empty()) {
    throw InputError(
        fmt::format("reverberation times that a room of {} cannot have: {}", size_text(size),
                    impossible),
        "change rt60 in these octaves, or the size, or the air (temperature, humidity)");
  }
  for (std::size_t b = octaves; b < octave_count; ++b) absorption[b] = absorption[octaves - 1];
  return absorption;
}

std::string size_text(const Eigen::Vector3d& size) {
  return fmt::format("{:.4g} x {:.4g} x {:.4g} m", size.x(), size.y(), size.z());
}

void check_room_size(const Eigen::Vector3d& size) {
  if (!(size.array() >= 1e-6).all() || !(size.array() <= 1e6).all()) {
    throw InputError(fmt::format("a room of {}", size_text(size)),
                     "its sides are lengths from a micrometre to a thousand kilometres");
  }
}

}  // namespace carillon::synth::room
