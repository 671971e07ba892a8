#include "synth/motion/fractal_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::synth::motion {

namespace {

constexpr int max_octaves = 24;
/// Mean variance of one octave: 8 corners x 2/3 (of a random gradient) x 3 A B^2, with A and B the
/// integrals of (1 - fade)^2 t^2 and (1 - fade)^2 over a cell.
constexpr double noise_variance = 0.072918945691195;

/// SplitMix64's finaliser (Steele, Lea and Flood 2014): every bit of the input reaches all of the
/// output.
std::uint64_t mixed(std::uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9ULL;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Gradient of a lattice point times the way from it: one of twelve directions, the edges of a
/// cube.
double corner(std::uint64_t half, double x, double y, double z) {
  const auto which = static_cast<unsigned>(half * 12 >> 32);
  const unsigned axis = which >> 2;
  const double a = axis == 0 ? y : x, b = axis == 2 ? y : z;
  return ((which & 1U) != 0 ? -a : a) + ((which & 2U) != 0 ? -b : b);
}

/// Two noises, of the halves of the same hashes.
Eigen::Array2d gradient_noise(std::uint64_t key, const Vec3& place) {
  std::uint64_t cell[3][2];
  double rest[3], fade[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double whole = std::floor(place[axis]);
    const double t = place[axis] - whole;
    rest[axis] = t;
    fade[axis] = t * t * t * (t * (6 * t - 15) + 10);
    const auto index = static_cast<std::uint64_t>(static_cast<std::int64_t>(whole));
    constexpr std::uint64_t odd[3] = {0x9e3779b97f4a7c15ULL, 0xc2b2ae3d27d4eb4fULL,
                                      0x165667b19e3779f9ULL};
    cell[axis][0] = index * odd[axis];
    cell[axis][1] = (index + 1) * odd[axis];
  }
  Eigen::Array2d planes[2];
  for (int k = 0; k < 2; ++k) {
    Eigen::Array2d rows[2];
    for (int j = 0; j < 2; ++j) {
      Eigen::Array2d ends[2];
      for (int i = 0; i < 2; ++i) {
        const std::uint64_t hash = mixed(key ^ mixed(cell[0][i] + cell[1][j] + cell[2][k]));
        const double x = rest[0] - i, y = rest[1] - j, z = rest[2] - k;
        ends[i] =
            Eigen::Array2d(corner(hash >> 32, x, y, z), corner(hash & 0xffffffffULL, x, y, z));
      }
      rows[j] = ends[0] + fade[0] * (ends[1] - ends[0]);
    }
    planes[k] = rows[0] + fade[1] * (rows[1] - rows[0]);
  }
  return planes[0] + fade[2] * (planes[1] - planes[0]);
}

}  // namespace

FractalNoise::FractalNoise(std::uint64_t seed, double longest, double exponent)
    : key_(core::RandomStream(seed, 0, "contact.fractal").next()),
      longest_(longest),
      exponent_(exponent) {
  if (!(longest > 0) || !std::isfinite(longest) || !(exponent > 1 && exponent <= 5)) {
    throw core::InputError(
        fmt::format("fractal noise: a longest wave of {} m and an exponent of {}", longest,
                    exponent),
        "the wave must be positive, the exponent above 1 and at most 5");
  }
}

Eigen::Vector2d FractalNoise::at(const Vec3& place, double shortest) const {
  // Variances of octaves fall by this factor and sum to one.
  const double fall = std::exp2(1 - exponent_);
  double variance = (1 - fall) / noise_variance;
  double wave = longest_;
  Eigen::Array2d sum = Eigen::Array2d::Zero();
  for (int octave = 0; octave < max_octaves; ++octave) {
    // Present from twice the shortest wave on.
    const double fraction = std::min(1.0, wave / shortest - 1);
    if (fraction <= 0) break;
    sum += fraction * std::sqrt(variance) *
           gradient_noise(key_ + static_cast<std::uint64_t>(octave), place / wave);
    variance *= fall;
    wave /= 2;
  }
  return sum.matrix();
}

}  // namespace carillon::synth::motion
