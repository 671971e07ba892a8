#include "eval/networks/detail/normalised_maximum.hpp"

#include <algorithm>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "eval/networks/detail/normalised_maximum.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carillon::eval::networks::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Lanes = hn::CappedTag<float, 16>;
using Whole = hn::Rebind<std::int32_t, Lanes>;

/// Rows that are added up before their sum goes into one of doubles.
constexpr std::size_t block_rows = 64;

/// Adds a vector of floats to as many doubles.
HWY_INLINE void add_to(double* sums, hn::Vec<Lanes> values) {
  const Lanes lanes;
  HWY_ALIGN float parts[16];
  hn::Store(values, lanes, parts);
  for (std::size_t i = 0; i < hn::Lanes(lanes); ++i) sums[i] += static_cast<double>(parts[i]);
}

/// Sums of the values, or of their squared distances from a centre.
void add_moments(const float* values, const MaximumExtent& extent, const float* centre,
                 bool squared, double* sums) {
  const Lanes lanes;
  for (std::size_t first = 0; first < extent.rows; first += block_rows) {
    const std::size_t end = std::min(extent.rows, first + block_rows);
    for (std::size_t c = 0; c < extent.channels; c += hn::Lanes(lanes)) {
      const auto middle = hn::LoadU(lanes, centre + c);
      auto sum = hn::Zero(lanes);
      for (std::size_t row = first; row < end; ++row) {
        const auto away = hn::Sub(hn::LoadU(lanes, values + row * extent.channels + c), middle);
        sum = hn::Add(sum, squared ? hn::Mul(away, away) : away);
      }
      add_to(sums + c, sum);
    }
  }
}

void find_maxima(const float* values, const MaximumExtent& extent, const float* scale,
                 const float* shift, float* maxima, float* peaks, std::int32_t* places) {
  const Lanes lanes;
  const Whole whole;
  for (std::size_t group = 0; group < extent.rows / extent.window; ++group) {
    const float* rows = values + group * extent.window * extent.channels;
    const std::size_t to = group * extent.channels;
    for (std::size_t c = 0; c < extent.channels; c += hn::Lanes(lanes)) {
      const auto by = hn::LoadU(lanes, scale + c), plus = hn::LoadU(lanes, shift + c);
      auto peak = hn::LoadU(lanes, rows + c);
      auto largest = hn::Add(hn::Mul(peak, by), plus);
      auto place = hn::Zero(whole);
      for (std::size_t p = 1; p < extent.window; ++p) {
        const auto value = hn::LoadU(lanes, rows + p * extent.channels + c);
        const auto normalised = hn::Add(hn::Mul(value, by), plus);
        const auto above = hn::Gt(normalised, largest);
        largest = hn::IfThenElse(above, normalised, largest);
        peak = hn::IfThenElse(above, value, peak);
        place = hn::IfThenElse(hn::RebindMask(whole, above),
                               hn::Set(whole, static_cast<std::int32_t>(p)), place);
      }
      hn::StoreU(hn::Max(largest, hn::Zero(lanes)), lanes, maxima + to + c);
      hn::StoreU(peak, lanes, peaks + to + c);
      hn::StoreU(place, whole, places + to + c);
    }
  }
}

void add_maxima(const float* gradient, const float* maxima, const float* peaks,
                const MaximumExtent& extent, double* plain, double* by_peak) {
  const Lanes lanes;
  const std::size_t groups = extent.rows / extent.window;
  for (std::size_t first = 0; first < groups; first += block_rows) {
    const std::size_t end = std::min(groups, first + block_rows);
    for (std::size_t c = 0; c < extent.channels; c += hn::Lanes(lanes)) {
      auto sum = hn::Zero(lanes), product = hn::Zero(lanes);
      for (std::size_t group = first; group < end; ++group) {
        const std::size_t at = group * extent.channels + c;
        const auto passes = hn::Gt(hn::LoadU(lanes, maxima + at), hn::Zero(lanes));
        const auto slope = hn::IfThenElseZero(passes, hn::LoadU(lanes, gradient + at));
        sum = hn::Add(sum, slope);
        product = hn::Add(product, hn::Mul(slope, hn::LoadU(lanes, peaks + at)));
      }
      add_to(plain + c, sum);
      add_to(by_peak + c, product);
    }
  }
}

void spread_gradient(const float* values, const float* gradient, const float* maxima,
                     const std::int32_t* places, const MaximumExtent& extent, const float* scale,
                     const float* constant, const float* linear, float* found) {
  const Lanes lanes;
  const Whole whole;
  for (std::size_t group = 0; group < extent.rows / extent.window; ++group) {
    const std::size_t rows = group * extent.window * extent.channels;
    const std::size_t from = group * extent.channels;
    for (std::size_t c = 0; c < extent.channels; c += hn::Lanes(lanes)) {
      const auto passes = hn::Gt(hn::LoadU(lanes, maxima + from + c), hn::Zero(lanes));
      const auto slope = hn::IfThenElseZero(
          passes, hn::Mul(hn::LoadU(lanes, gradient + from + c), hn::LoadU(lanes, scale + c)));
      const auto place = hn::LoadU(whole, places + from + c);
      const auto base = hn::LoadU(lanes, constant + c), by = hn::LoadU(lanes, linear + c);
      for (std::size_t p = 0; p < extent.window; ++p) {
        const std::size_t at = rows + p * extent.channels + c;
        const auto here =
            hn::RebindMask(lanes, hn::Eq(place, hn::Set(whole, static_cast<std::int32_t>(p))));
        const auto own = hn::Add(base, hn::Mul(by, hn::LoadU(lanes, values + at)));
        hn::StoreU(hn::Add(own, hn::IfThenElseZero(here, slope)), lanes, found + at);
      }
    }
  }
}

}  // namespace carillon::eval::networks::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carillon::eval::networks {

HWY_EXPORT(add_moments);
HWY_EXPORT(find_maxima);
HWY_EXPORT(add_maxima);
HWY_EXPORT(spread_gradient);

void channel_moments(const float* values, const MaximumExtent& extent, std::span<float> mean,
                     std::span<float> variance) {
  const auto rows = static_cast<double>(extent.rows);
  std::vector<double> sums(extent.channels, 0.0);
  std::fill(mean.begin(), mean.end(), 0.0F);
  HWY_DYNAMIC_DISPATCH(add_moments)(values, extent, mean.data(), false, sums.data());
  for (std::size_t c = 0; c < mean.size(); ++c) mean[c] = static_cast<float>(sums[c] / rows);
  std::fill(sums.begin(), sums.end(), 0.0);
  HWY_DYNAMIC_DISPATCH(add_moments)(values, extent, mean.data(), true, sums.data());
  for (std::size_t c = 0; c < mean.size(); ++c) variance[c] = static_cast<float>(sums[c] / rows);
}

void normalised_maximum(const float* values, const MaximumExtent& extent,
                        std::span<const float> scale, std::span<const float> shift, float* maxima,
                        float* peaks, std::int32_t* places) {
  HWY_DYNAMIC_DISPATCH(find_maxima)
  (values, extent, scale.data(), shift.data(), maxima, peaks, places);
}

void maximum_sums(const float* gradient, const float* maxima, const float* peaks,
                  const MaximumExtent& extent, std::span<double> plain, std::span<double> by_peak) {
  HWY_DYNAMIC_DISPATCH(add_maxima)
  (gradient, maxima, peaks, extent, plain.data(), by_peak.data());
}

void maximum_gradient(const float* values, const float* gradient, const float* maxima,
                      const std::int32_t* places, const MaximumExtent& extent,
                      std::span<const float> scale, std::span<const float> constant,
                      std::span<const float> linear, float* found) {
  HWY_DYNAMIC_DISPATCH(spread_gradient)
  (values, gradient, maxima, places, extent, scale.data(), constant.data(), linear.data(), found);
}

}  // namespace carillon::eval::networks
#endif
