#include "synth/room/image_sources.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "core/error.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::synth::room {

using core::InputError;

namespace {

constexpr double half_kernel = 40;  ///< [samples]

std::string place_text(const Eigen::Vector3d& p) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g}) m", p.x(), p.y(), p.z());
}

/// A source mirrored `n` times along one axis (n < 0: the first time at the wall at 0).
struct Mirrored {
  double position;
  int low, high;  ///< reflections at the wall at 0 and at the other
};

Mirrored mirrored(double source, double length, int n) {
  const int count = std::abs(n);
  Mirrored image{};
  image.position = n * length + (count % 2 == 0 ? source : length - source);
  image.low = (count + (n < 0 ? 1 : 0)) / 2;
  image.high = count - image.low;
  return image;
}

}  // namespace

void check_room(const Eigen::Vector3d& size, const Eigen::Vector3d& source,
                const Eigen::Vector3d& listener, int order) {
  check_room_size(size);
  if (order < 0 || order > highest_order) {
    throw InputError(
        fmt::format("image sources up to order {}", order),
        fmt::format("choose an order from 0 to {}; the tail holds what is later", highest_order));
  }
  const auto inside = [&size](const Eigen::Vector3d& p) {
    return (p.array() > 0).all() && (p.array() < size.array()).all();
  };
  if (!inside(source)) {
    throw InputError(fmt::format("the source at {} is not inside the room of {}",
                                 place_text(source), size_text(size)),
                     "walls are at 0 and at the room's size: move the source between them");
  }
  if (!inside(listener)) {
    throw InputError(fmt::format("the listener at {} is not inside the room of {}",
                                 place_text(listener), size_text(size)),
                     "make the room larger, or move source and listener between the walls");
  }
  if (!((source - listener).norm() > 0)) {
    throw InputError(fmt::format("source and listener are both at {}", place_text(source)),
                     "move the listener away from the object");
  }
}

std::vector<ImageSource> image_sources(const Eigen::Vector3d& size, const Eigen::Vector3d& source,
                                       const Eigen::Vector3d& listener, int order) {
  std::vector<ImageSource> images;
  for (int nx = -order; nx <= order; ++nx) {
    const int rest_x = order - std::abs(nx);
    for (int ny = -rest_x; ny <= rest_x; ++ny) {
      const int rest_y = rest_x - std::abs(ny);
      for (int nz = -rest_y; nz <= rest_y; ++nz) {
        const Mirrored x = mirrored(source.x(), size.x(), nx);
        const Mirrored y = mirrored(source.y(), size.y(), ny);
        const Mirrored z = mirrored(source.z(), size.z(), nz);
        ImageSource image;
        image.position = {x.position, y.position, z.position};
        image.hits = {x.low, x.high, y.low, y.high, z.low, z.high};
        image.order = std::abs(nx) + std::abs(ny) + std::abs(nz);
        image.distance = (image.position - listener).norm();
        if (image.order > 0) images.push_back(image);
      }
    }
  }
  std::stable_sort(images.begin(), images.end(), [](const ImageSource& a, const ImageSource& b) {
    return a.distance < b.distance;
  });
  return images;
}

OctaveValues image_gains(const ImageSource& image, double direct, const WallAbsorption& walls,
                         const OctaveValues& m) {
  OctaveValues gains;
  for (std::size_t b = 0; b < octave_count; ++b) {
    gains[b] = direct / image.distance * std::exp(-m[b] * (image.distance - direct) / 2);
    for (std::size_t w = 0; w < wall_count; ++w) {
      gains[b] *= std::pow(1 - walls[w][b], image.hits[w] / 2.0);
    }
  }
  return gains;
}

DelayKernel fractional_delay(double delay) {
  const double half = std::clamp(std::floor(delay), 1.0, half_kernel);
  DelayKernel kernel;
  kernel.first = static_cast<std::size_t>(std::max(0.0, std::ceil(delay - half)));
  double sum = 0;
  for (auto n = static_cast<double>(kernel.first); n <= delay + half; ++n) {
    const double x = std::numbers::pi * (n - delay);
    const double sinc = std::abs(x) < 1e-9 ? 1 : std::sin(x) / x;
    const double window = 0.5 + 0.5 * std::cos(x / half);
    // Two samples hold no more than a straight line.
    kernel.weights.push_back(half > 1 ? sinc * window : std::max(0.0, 1 - std::abs(n - delay)));
    sum += kernel.weights.back();
  }
  for (double& weight : kernel.weights) weight /= sum;
  return kernel;
}

std::vector<double> image_response(std::span<const ImageSource> images, double direct,
                                   const WallAbsorption& walls, const Air& air, double sample_rate,
                                   std::size_t count, const ReflectionFilters& filters) {
  std::vector<double> response(count, 0.0);
  const double speed = sound_speed(air);
  const OctaveValues m = air_absorption(air);
  signal::RealFft fft(filters.fft_size());
  for (const ImageSource& image : images) {
    // An image beside the source may be nearer by a rounding error.
    const double delay = std::max(0.0, (image.distance - direct) / speed * sample_rate);
    if (!(delay < static_cast<double>(count))) break;  // nearest first
    const OctaveValues gains = image_gains(image, direct, walls, m);
    if (std::all_of(gains.begin(), gains.begin() + filters.octaves(),
                    [](double g) { return g < 1e-9; })) {
      continue;
    }
    const DelayKernel kernel = fractional_delay(delay);
    std::fill(std::copy(kernel.weights.begin(), kernel.weights.end(), fft.signal().begin()),
              fft.signal().end(), 0.0);
    fft.forward();
    filters.apply(gains, fft.spectrum());
    fft.inverse();
    const std::size_t heard = std::min(fft.size(), count - std::min(count, kernel.first));
    for (std::size_t n = 0; n < heard; ++n) response[kernel.first + n] += fft.signal()[n];
  }
  return response;
}

}  // namespace carillon::synth::room
