#include "scene/tuned_object.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "solvers/families/families.hpp"

namespace carillon::scene {

namespace {

void check_tuning(const ObjectRequest& request, const Tuning& tuning) {
  const solvers::modes::Band& band = request.solve.band;
  if (!(tuning.frequency > 0) || !std::isfinite(tuning.frequency)) {
    throw core::InputError(
        fmt::format("an object is tuned to a frequency, not to {} Hz", tuning.frequency));
  }
  if (tuning.mode < 1 || tuning.mode > band.max_modes) {
    throw core::InputError(
        fmt::format("mode {} is none of the {} that are asked for", tuning.mode, band.max_modes),
        "modes count from 1, the lowest; max_modes bounds them");
  }
  if (tuning.frequency < band.min_frequency || tuning.frequency > band.max_frequency) {
    throw core::InputError(
        fmt::format("{:.6g} Hz, the pitch to tune to, lies outside the band of {:.6g} to {:.6g} Hz",
                    tuning.frequency, band.min_frequency, band.max_frequency),
        "widen min_frequency or max_frequency");
  }
}

/// Longest side as the request has it [m].
double untuned_side(const ObjectRequest& request, MPI_Comm comm,
                    const std::filesystem::path& cache) {
  if (!request.mesh.shape.family.empty()) {
    return solvers::families::extent_of(request.mesh.shape).longest_side;
  }
  const solvers::mesh::MeshResult mesh = shared_mesh(request.mesh, request.limits, cache, comm);
  return solvers::mesh::bounding_box(mesh.mesh.nodes).longest_side();
}

}  // namespace

double untuned_frequency(ObjectRequest probe, int mode, MPI_Comm comm,
                         const std::filesystem::path& cache, core::Trace& trace) {
  probe.any_size = probe.mesh.file.any_size = true;  // that size is not the object's
  probe.pitch_cents = 0;
  probe.solve.estimate_errors = false;
  // Beyond the mode, so that no cluster of equal frequencies that it begins is left out.
  constexpr int cluster = 10;
  double speed = 100;  // of waves along a bar [m/s]; no solid's is less by much
  for (const synth::material::Material& material : listed(probe.materials)) {
    speed = std::max(speed, std::sqrt(material.elastic.youngs_modulus / material.elastic.density));
  }
  // A compact body's first mode has half a wave along it, a slender or thin one's lies lower. What
  // is empty of modes costs little.
  constexpr int tries = 12;
  double top = speed / untuned_side(probe, comm, cache) / 16;
  for (int attempt = 0; attempt < tries; ++attempt, top *= 4) {
    probe.solve.band = {0, top, mode + cluster};
    const SolvedObject found = solve_object(probe, comm, cache);
    trace.merge(found.trace);
    if (found.modes.size() >= static_cast<std::size_t>(mode)) {
      return found.modes.frequency(static_cast<std::size_t>(mode - 1));
    }
  }
  throw core::InputError(
      fmt::format("no mode {} was found up to {:.3g} Hz, to tune the object by", mode, top / 4));
}

namespace {

/// An object in another size, its mesh too.
void scale_object(SolvedObject& object, double size) {
  object.size = size;
  object.modes = solvers::modes::rescale(object.modes, size, 1, 1);
  solvers::mesh::TetMesh& mesh = object.mesh.mesh;
  for (auto* nodes : {&mesh.nodes, &mesh.finer_nodes, &mesh.finer_gaps}) {
    for (Vec3& node : *nodes) node *= size;
  }
  object.mesh.quality.volume *= size * size * size;
}

}  // namespace

SolvedObject solve_tuned(const ObjectRequest& request, const Tuning& tuning, MPI_Comm comm,
                         const std::filesystem::path& cache) {
  check_tuning(request, tuning);
  ObjectRequest untuned = request;
  untuned.any_size = untuned.mesh.file.any_size = true;  // that size is not the object's
  core::Trace trace;
  double size = untuned_frequency(untuned, tuning.mode, comm, cache, trace) / tuning.frequency;
  // Modes below the band lie below the one that is tuned.
  untuned.solve.band.min_frequency = 0;
  untuned.solve.band.max_modes = request.solve.band.max_modes + tuning.mode - 1;
  constexpr int tries = 4;
  for (int attempt = 1;; ++attempt) {
    untuned.solve.band.max_frequency = tuning_margin * size * request.solve.band.max_frequency;
    SolvedObject object = solve_object(untuned, comm, cache);
    trace.merge(object.trace);
    if (object.modes.size() < static_cast<std::size_t>(tuning.mode)) {
      throw core::SolverError(
          fmt::format("mode {}, to tune the object by, was found by a first "
                      "solve and not by the second",
                      tuning.mode));
    }
    size = object.modes.frequency(static_cast<std::size_t>(tuning.mode - 1)) / tuning.frequency;
    const bool reaches =
        untuned.solve.band.max_frequency >= size * request.solve.band.max_frequency;
    if (!reaches && attempt < tries) continue;
    scale_object(object, size);
    object.modes = solvers::modes::restrict_to(object.modes, request.solve.band);
    object.trace = std::move(trace);
    check_size(solvers::mesh::bounding_box(object.modes.surface.nodes).longest_side(),
               request.any_size);
    return object;
  }
}

}  // namespace carillon::scene
