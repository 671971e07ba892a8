#include "solvers/modes/mode_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "core/error.hpp"

namespace carillon::solvers::modes {
namespace {

/// Cosine and sine of an angle.
using Direction = Eigen::Vector2d;

Direction direction_of(int part, int around) {
  const double angle = 2 * std::numbers::pi * part / around;
  return {std::cos(angle), std::sin(angle)};
}

/// Directions of all nodes of rings, by the number of these.
class Circles {
 public:
  const std::vector<Direction>& of(int around) {
    std::vector<Direction>& circle = known_[around];
    for (int k = static_cast<int>(circle.size()); k < around; ++k)
      circle.push_back(direction_of(k, around));
    return circle;
  }

 private:
  std::map<int, std::vector<Direction>> known_;
};

/// @param amplitudes  along the radius, around, along z
/// @param phase       of the harmonic times the angle of `place`
Vec3 displacement(const Eigen::Vector3f& amplitudes, const CircumferentialWave& wave,
                  const Direction& place, const Direction& phase) {
  const Vec3 a = amplitudes.cast<double>();
  const double c = phase.x(), s = phase.y();
  const double even = wave.turned ? s : c;
  const double radial = a[0] * even, axial = a[2] * even;
  // n = 0 has no turned mode, and its rotation goes with the cosine.
  const double around = wave.harmonic == 0 ? a[1] : wave.turned ? -a[1] * c : a[1] * s;
  return {radial * place.x() - around * place.y(), radial * place.y() + around * place.x(), axial};
}

/// Of a node of a ring, the part of the turn that a harmonic has made there.
int phase_of(int harmonic, int part, int around) {
  return static_cast<int>(std::int64_t{harmonic} * part % around);
}

/// @return x y z of every node
Eigen::VectorXd unfold(const Eigen::Ref<const Eigen::RowVectorXf>& amplitudes,
                       const CircumferentialWave& wave, std::span<const NodeRing> rings,
                       Eigen::Index nodes, Circles& circles) {
  Eigen::VectorXd out(3 * nodes);
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const Eigen::Vector3f on_ring = amplitudes.segment<3>(3 * static_cast<Eigen::Index>(r));
    const auto [first, around] = rings[r];
    const std::vector<Direction>& circle = circles.of(around);
    for (int k = 0; k < around; ++k) {
      out.segment<3>(3 * Eigen::Index{first + k}) =
          displacement(on_ring, wave, circle[static_cast<std::size_t>(k)],
                       circle[static_cast<std::size_t>(phase_of(wave.harmonic, k, around))]);
    }
  }
  return out;
}

}  // namespace

ModeShapes::ModeShapes(Rows at_nodes) : values_(std::move(at_nodes)) {}

ModeShapes::ModeShapes(Rows amplitudes, std::vector<NodeRing> rings,
                       std::vector<CircumferentialWave> waves)
    : values_(std::move(amplitudes)), rings_(std::move(rings)), waves_(std::move(waves)) {
  std::int64_t next = 0;
  for (const NodeRing& ring : rings_) {
    if (ring.first != next || ring.around < 1)
      throw core::InputError("the nodes of a turned surface are not in rings");
    next += ring.around;
  }
  if (!rings_.empty() && (waves_.size() != static_cast<std::size_t>(values_.rows()) ||
                          values_.cols() != 3 * static_cast<Eigen::Index>(rings_.size())))
    throw core::InputError(
        "shapes on a turned surface need a wave for each mode and three "
        "amplitudes for each ring");
}

Eigen::Index ModeShapes::nodes() const {
  return rings_.empty() ? values_.cols() / 3
                        : Eigen::Index{rings_.back().first} + rings_.back().around;
}

Eigen::VectorXd ModeShapes::of(Eigen::Index mode) const {
  if (rings_.empty()) return values_.row(mode).transpose().cast<double>();
  Circles circles;
  return unfold(values_.row(mode), waves_[static_cast<std::size_t>(mode)], rings_, nodes(),
                circles);
}

Eigen::MatrixX3d ModeShapes::at(Eigen::Index node) const {
  if (rings_.empty()) return values_.middleCols<3>(3 * node).cast<double>();
  const auto after =
      std::upper_bound(rings_.begin(), rings_.end(), node,
                       [](Eigen::Index n, const NodeRing& ring) { return n < ring.first; });
  const Eigen::Index r = after - rings_.begin() - 1;
  const auto [first, around] = rings_[static_cast<std::size_t>(r)];
  const int part = static_cast<int>(node) - first;
  const Direction place = direction_of(part, around);
  Eigen::MatrixX3d out(modes(), 3);
  for (Eigen::Index mode = 0; mode < modes(); ++mode) {
    const CircumferentialWave& wave = waves_[static_cast<std::size_t>(mode)];
    out.row(mode) = displacement(values_.block<1, 3>(mode, 3 * r), wave, place,
                                 direction_of(phase_of(wave.harmonic, part, around), around))
                        .transpose();
  }
  return out;
}

ModeShapes::Rows ModeShapes::at_nodes() const {
  if (rings_.empty()) return values_;
  Circles circles;
  Rows out(modes(), 3 * nodes());
  for (Eigen::Index mode = 0; mode < modes(); ++mode) {
    out.row(mode) =
        unfold(values_.row(mode), waves_[static_cast<std::size_t>(mode)], rings_, nodes(), circles)
            .cast<float>()
            .transpose();
  }
  return out;
}

ModeShapes ModeShapes::select(std::span<const Eigen::Index> chosen) const {
  const std::vector<Eigen::Index> rows(chosen.begin(), chosen.end());
  ModeShapes out;
  out.values_ = values_(rows, Eigen::all);
  out.rings_ = rings_;
  for (const Eigen::Index row : rows)
    if (!waves_.empty()) out.waves_.push_back(waves_[static_cast<std::size_t>(row)]);
  return out;
}

ModeShapes& ModeShapes::operator*=(float factor) {
  values_ *= factor;
  return *this;
}

std::vector<int> ModeShapes::harmonics() const {
  std::vector<int> out;
  for (const CircumferentialWave& wave : waves_) out.push_back(wave.harmonic);
  return out;
}

}  // namespace carillon::solvers::modes
