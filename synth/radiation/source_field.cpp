#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "synth/radiation/equivalent_sources.hpp"
#include "synth/surface/surface_patches.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "synth/radiation/source_field.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, as Highway asks.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carillon::synth::radiation::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// (steady + i k moving) exp(-i k r) of every point, by its parts.
void add_waves(const double* distances, const double* steady, const double* moving,
               std::size_t count, double wavenumber, double* real, double* imag) {
  const hn::CappedTag<double, 8> lanes;
  const std::size_t width = hn::Lanes(lanes);
  const auto k = hn::Set(lanes, wavenumber);
  // Arrays are filled up to whole vectors.
  for (std::size_t i = 0; i < count; i += width) {
    const auto phase = hn::Mul(k, hn::LoadU(lanes, distances + i));
    const auto sine = hn::Sin(lanes, phase);
    const auto cosine = hn::Cos(lanes, phase);
    const auto a = hn::LoadU(lanes, steady + i);
    const auto b = hn::Mul(k, hn::LoadU(lanes, moving + i));
    hn::StoreU(hn::MulAdd(a, cosine, hn::Mul(b, sine)), lanes, real + i);
    hn::StoreU(hn::MulSub(b, cosine, hn::Mul(a, sine)), lanes, imag + i);
  }
}

}  // namespace carillon::synth::radiation::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carillon::synth::radiation {

HWY_EXPORT(add_waves);

namespace {

/// Most numbers in one vector: arrays have room for a whole one at their end.
constexpr Eigen::Index room = 8;
/// Phases up to which Highway's sine and cosine are good [rad].
constexpr double largest_phase = 39000;

}  // namespace

SourceField::SourceField(EquivalentSources sources) : sources_(std::move(sources)) {
  for (const Vec3& vertex : sources_.outline.vertices) {
    reach_ = std::max(reach_, (vertex - sources_.centroid).norm());
  }
  real_ = sources_.strengths * sources_.amplitudes.real();
  imag_ = sources_.strengths * sources_.amplitudes.imag();
}

void SourceField::check(std::size_t row, const Vec3& position) const {
  if (!position.allFinite()) {
    throw core::InputError(fmt::format("listener {}: position is not finite", row));
  }
  if ((position - sources_.centroid).norm() >= reach_ + sources_.nearest) return;
  const double distance = surface::distance_from(sources_.outline, position);
  const bool inside = solvers::mesh::winding_number(sources_.outline, position) > 0.5;
  if (inside || !(distance >= sources_.nearest)) {
    throw core::InputError(
        fmt::format("listener {} is {} the object, {:.4g} m {} its surface", row,
                    inside ? "inside" : "too near to", distance, inside ? "under" : "off"),
        fmt::format("equivalent sources are meant from {:.4g} m off the surface",
                    sources_.nearest));
  }
}

ModalPressure SourceField::pressure_at(std::span<const modal::Listener> listeners) const {
  const auto count = static_cast<Eigen::Index>(sources_.points.size());
  ModalPressure result;
  result.pressure.resize(static_cast<Eigen::Index>(listeners.size()),
                         static_cast<Eigen::Index>(sources_.modes()));
  Eigen::ArrayXd distances = Eigen::ArrayXd::Ones(count + room);
  Eigen::ArrayXd steady = Eigen::ArrayXd::Zero(count + room);
  Eigen::ArrayXd moving = steady;
  Eigen::VectorXd real(count + room), imag(count + room);
  for (std::size_t row = 0; row < listeners.size(); ++row) {
    const Vec3& position = listeners[row].position;
    check(row, position);
    const double flight = (position - sources_.centroid).norm() / modal::speed_of_sound;
    result.delays.push_back(flight);
    for (Eigen::Index point = 0; point < count; ++point) {
      const auto j = static_cast<std::size_t>(point);
      const Vec3 way = position - sources_.points[j];
      const double r = way.norm();
      const double cosine = way.dot(sources_.directions[j]) / r;
      // A dipole, and 1 / R + i k monopoles.
      distances[point] = r;
      steady[point] = (cosine / r + 1 / sources_.size) / (4 * std::numbers::pi * r);
      moving[point] = (cosine + 1) / (4 * std::numbers::pi * r);
    }
    // What all points fraction of their distance is no matter of phase, and far listeners keep it
    // small.
    const double shared = distances.head(count).minCoeff();
    distances.head(count) -= shared;
    double k = -1;
    for (std::size_t mode = 0; mode < sources_.modes(); ++mode) {
      if (sources_.wavenumbers[mode] != k) {
        k = sources_.wavenumbers[mode];
        if (k * distances.head(count).maxCoeff() > largest_phase) {
          throw core::InputError(
              fmt::format("an object of {:.4g} m is too large for waves of {:.3g} m",
                          distances.head(count).maxCoeff(), 2 * std::numbers::pi / k));
        }
        HWY_DYNAMIC_DISPATCH(add_waves)
        (distances.data(), steady.data(), moving.data(), static_cast<std::size_t>(count), k,
         real.data(), imag.data());
      }
      const auto m = static_cast<Eigen::Index>(mode);
      const auto re = real.head(count), im = imag.head(count);
      const std::complex<double> sum(re.dot(real_.col(m)) - im.dot(imag_.col(m)),
                                     re.dot(imag_.col(m)) + im.dot(real_.col(m)));
      result.pressure(static_cast<Eigen::Index>(row), m) =
          std::polar(1.0, k * (modal::speed_of_sound * flight - shared)) * sum;
    }
  }
  return result;
}

}  // namespace carillon::synth::radiation
#endif  // HWY_ONCE
