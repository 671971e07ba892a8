#pragma once

#include <vector>

#include "dataset/samples/modes_task.hpp"
#include "synth/surface/rigid_body.hpp"

namespace carillon::dataset::samples {

/// What a shape is drawn with beside its materials.
struct ShapeLooks {
  std::vector<Vec3> colours;               ///< of the shape's file, at the vertices; empty: none
  std::vector<std::int32_t> face_regions;  ///< of the surface's faces; empty: all of one region
};

/// What the variants of a shape are made of, and which mode sets of its file they use.
struct PlacedVariants {
  std::vector<std::vector<synth::material::Material>> materials;  ///< of each, one per region
  ModeSets sets;
};
/// @param file  the shape's modes file, of whose modes nothing is read
/// @throws FileError  it is damaged
PlacedVariants placed_variants(const configuration::BuildConfig& config, const plan::Shape& shape,
                               const core::Hdf5Group& file);

/// Modes of a shape in its materials and sizes, from its modes file.
class ShapeModes {
 public:
  /// @throws FileError  the modes file is missing or damaged
  ShapeModes(const configuration::BuildConfig& config, const plan::Shape& shape,
             const BuildFolders& folders);

  /// Materials of a variant, one per region.
  const std::vector<synth::material::Material>& materials(std::size_t variant) const {
    return placed_.materials[variant];
  }
  /// Factor of a variant's lengths: as planned, or what its pitch led to.
  double size(std::size_t variant) const { return placed_.sets.variants[variant].length; }
  /// Number of the set that its modes are of.
  std::size_t set_of(std::size_t variant) const { return placed_.sets.variants[variant].set; }
  /// How many modes of that set lie below the configuration's band.
  std::size_t modes_below(std::size_t variant) const;
  /// Modes of a variant in the configuration's band.
  solvers::modes::Modes of(std::size_t variant) const;
  /// At size 1.
  const solvers::modes::ModeSurface& surface() const { return solved_.front().surface; }
  /// Corners of the object's convex pieces at size 1 [m]; empty where the build has no motion.
  const std::vector<std::vector<Vec3>>& hulls() const { return hulls_; }
  /// Empty where the build draws nothing.
  const ShapeLooks& looks() const { return looks_; }
  /// Of its regions at size 1; empty where it has one only.
  const std::vector<synth::surface::RegionMoments>& moments() const { return moments_; }

 private:
  solvers::modes::Band band_;
  PlacedVariants placed_;
  std::vector<solvers::modes::Modes> solved_;
  std::vector<std::vector<Vec3>> hulls_;
  std::vector<synth::surface::RegionMoments> moments_;
  ShapeLooks looks_;
};

/// Estimated pitch errors of every mode of every set of a modes file [cent].
/// @throws FileError  it is damaged
std::vector<double> read_pitch_errors(const core::Hdf5Group& file);

/// Writes the pieces as `hulls/points` [n, 3] and `hulls/first` [pieces + 1].
void write_hulls(const core::Hdf5Group& file, const std::vector<std::vector<Vec3>>& hulls);

/// Looks of all faces of a shape.
struct DrawnLooks {
  render::looks::Appearance body;  ///< of the first region
  render::looks::FaceLooks faces;  ///< of the others
};
/// The materials' looks, pieces of them that are the shape's own, and the colours of its file.
/// @param materials  one for each region
/// @param surface    that the shape's faces are of
DrawnLooks looks_of(const plan::Shape& shape,
                    const std::vector<synth::material::Material>& materials,
                    const ShapeLooks& looks, const solvers::modes::ModeSurface& surface);

/// Writes `colours` [vertices, 3] and `face_regions` [faces]; nothing of what is not there.
void write_looks(const core::Hdf5Group& file, const ShapeLooks& looks);

/// Writes `moments/volume` [regions], `moments/centroid` [regions, 3] and `moments/spread`
/// [regions, 3, 3].
void write_moments(const core::Hdf5Group& file,
                   const std::vector<synth::surface::RegionMoments>& moments);

}  // namespace carillon::dataset::samples
