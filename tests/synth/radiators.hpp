#pragma once

#include <cmath>
#include <complex>
#include <numbers>

#include "synth/radiation/equivalent_sources.hpp"
#include "tests/synth/curved_bodies.hpp"

namespace carillon::synth {

using Complex = std::complex<double>;

inline double legendre(int order, double x) {
  const double values[] = {1, x, 1.5 * x * x - 0.5, 2.5 * x * x * x - 1.5 * x};
  return values[order];
}

/// Spherical Hankel function of the second kind by its recurrence: waves exp(-i x) / x.
inline Complex hankel(int order, double x) {
  const Complex wave = std::polar(1 / x, -x);
  Complex before = Complex(0, 1) * wave;
  if (order == 0) return before;
  Complex value = wave * Complex(-1, 1 / x);
  for (int n = 1; n < order; ++n) {
    const Complex next = (2 * n + 1) / x * value - before;
    before = value;
    value = next;
  }
  return value;
}

/// Pressure of a sphere of radius a about the origin whose normal acceleration is the Legendre
/// polynomial of an order, of the cosine to the z axis: p = -rho P h(kr) / (k h'(ka)).
inline Complex sphere_pressure(int order, double k, double a, const Vec3& x) {
  const double r = x.norm();
  const Complex slope = order / (k * a) * hankel(order, k * a) - hankel(order + 1, k * a);
  return -modal::air_density * legendre(order, x[2] / r) * hankel(order, k * r) / (k * slope);
}

/// Modes of a sphere about the origin, one of Legendre's polynomials at each k a.
inline solvers::modes::Modes sphere_modes(const solvers::modes::ModeSurface& sphere, double radius,
                                          int order, const std::vector<double>& ka) {
  std::vector<double> eigenvalues;
  for (const double value : ka) {
    eigenvalues.push_back(std::pow(value / radius * modal::speed_of_sound, 2));
  }
  return modes_with(sphere, eigenvalues, [&](int, const Vec3& x) -> Vec3 {
    return legendre(order, x.normalized()[2]) * x.normalized();
  });
}

/// Circular disc about the origin, faces at z = +-thickness / 2, first order; the polygon has the
/// circle's area.
inline solvers::modes::ModeSurface disc(double radius, double thickness, int rings = 10,
                                        int sides = 32) {
  solvers::modes::ModeSurface surface;
  const double turn = 2 * std::numbers::pi / sides;
  const double corner = radius * std::sqrt(turn / std::sin(turn));
  const auto index = [&](int face, int ring, int side) {
    return face + 2 * (ring == 0 ? 0 : 1 + (ring - 1) * sides + side % sides);
  };
  for (int ring = 0; ring <= rings; ++ring) {
    for (int side = 0; side < (ring == 0 ? 1 : sides); ++side) {
      const double r = corner * ring / rings;
      for (const double z : {-thickness / 2, thickness / 2}) {
        surface.nodes.push_back({r * std::cos(turn * side), r * std::sin(turn * side), z});
      }
    }
  }
  const auto add = [&](int a, int b, int c) {
    surface.faces.insert(surface.faces.end(), {a, b, c});
  };
  for (int side = 0; side < sides; ++side) {
    for (int ring = 0; ring < rings; ++ring) {
      for (const int face : {0, 1}) {
        const int a = index(face, ring, side), b = index(face, ring + 1, side);
        const int c = index(face, ring + 1, side + 1), d = index(face, ring, side + 1);
        face == 1 ? add(a, b, c) : add(a, c, b);
        if (ring > 0) face == 1 ? add(a, c, d) : add(a, d, c);
      }
    }
    const int a = index(0, rings, side), b = index(0, rings, side + 1);
    const int c = index(1, rings, side + 1), d = index(1, rings, side);
    add(a, b, c);
    add(a, c, d);
  }
  return surface;
}

/// A fit, heard.
struct Radiation {
  radiation::ModalPressure radiated;
  std::vector<double> residuals;
  std::vector<double> decay_rates;
};
inline Radiation heard_radiation(const solvers::modes::Modes& modes,
                                 std::span<const modal::Listener> listeners,
                                 const radiation::EquivalentSourcesOptions& options = {}) {
  const radiation::SourceField field(radiation::fit_equivalent_sources(modes, options));
  return {field.pressure_at(listeners), field.sources().residuals, field.sources().decay_rates};
}

inline double decibels(const Complex& found, const Complex& expected) {
  return 20 * std::log10(std::abs(found / expected));
}

}  // namespace carillon::synth
