#include "solvers/eigen/mirrored_solve.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <utility>

#include "mpi/comm.hpp"
#include "solvers/eigen/extract.hpp"
#include "solvers/mesh/raise_order.hpp"
#include "solvers/modes/modes_broadcast.hpp"

namespace carillon::solvers::eigen {
namespace {

constexpr std::size_t min_unknowns = 600;
/// Entries of a factor of n unknowns are less than this times n^(4/3), and it takes twice their
/// room while it is made (memory_needs).
constexpr double factor_entries = 200;
/// A class is asked for more modes than its share by this, as classes hold unequal numbers.
constexpr double share_excess = 1.15;
constexpr int share_spare = 4;
/// Times that classes are asked for more before the body is solved whole.
constexpr int max_requests = 4;
/// Modes crowd about as this power of the frequency: between 1 (plates) and 3 (solids).
constexpr double crowding = 1.5;

std::size_t count_between(const modes::Modes& modes, double low, double high) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    count += modes.frequency(k) >= low && modes.frequency(k) <= high;
  }
  return count;
}

/// To where a band's modes are known in every class [Hz].
double known_to(std::span<const ClassModes> classes) {
  double frequency = classes.front().modes.certificate.complete_to_hz;
  for (const auto& one : classes)
    frequency = std::min(frequency, one.modes.certificate.complete_to_hz);
  return frequency;
}

bool is_enough(std::span<const ClassModes> classes, const modes::Band& band) {
  const double top = known_to(classes);
  std::size_t count = 0;
  bool complete = true;
  for (const auto& [modes, truth] : classes) {
    complete = complete && modes.certificate.complete;
    count += count_between(modes, band.bottom(), top);
  }
  // One more shows whether the last is one of a cluster.
  return complete || count > static_cast<std::size_t>(band.max_modes);
}

/// Modes to ask of each class, that all of them together may hold a band's number; 0 for those that
/// hold enough as they are.
std::vector<int> further_shares(std::span<const ClassModes> classes, const modes::Band& band) {
  const auto expected = [&](const ClassModes& one, double top) {
    const double known = one.modes.certificate.complete_to_hz;
    const auto count = static_cast<double>(count_between(one.modes, band.bottom(), known));
    return top <= known ? static_cast<double>(count_between(one.modes, band.bottom(), top))
                        : (count + 1) * std::pow(top / known, crowding);
  };
  double top = known_to(classes);
  const auto enough = [&] {
    double sum = 0;
    for (const auto& one : classes) sum += expected(one, top);
    return sum > share_excess * band.max_modes + share_spare;
  };
  constexpr double step = 1.02;
  while (top < band.max_frequency && !enough()) top *= step;
  std::vector<int> shares;
  for (const auto& one : classes) {
    const auto& certificate = one.modes.certificate;
    const bool holds = certificate.complete || certificate.complete_to_hz >= top;
    shares.push_back(holds ? 0 : static_cast<int>(std::ceil(expected(one, top))) + share_spare);
  }
  return shares;
}

/// Which ranks solve which classes.
class Groups {
 public:
  Groups(std::size_t classes, MPI_Comm comm)
      : ranks_(static_cast<std::size_t>(mpi::size(comm))), count_(std::min(classes, ranks_)) {
    own_ = static_cast<std::size_t>(mpi::rank(comm)) * count_ / ranks_;
    MPI_Comm_split(comm, static_cast<int>(own_), mpi::rank(comm), comm_.put());
  }
  std::size_t count() const { return count_; }
  bool solves(std::size_t of_class) const { return of_class % count_ == own_; }
  int root(std::size_t of_class) const {
    const std::size_t group = of_class % count_;
    return static_cast<int>((group * ranks_ + count_ - 1) / count_);
  }
  MPI_Comm comm() const { return comm_.get(); }

 private:
  std::size_t ranks_, count_, own_ = 0;
  mpi::Comm comm_;
};

void broadcast(std::vector<std::optional<ClassModes>>& solved, std::size_t bands, int root,
               MPI_Comm comm) {
  solved.resize(bands);
  for (auto& one : solved) {
    bool there = one.has_value();
    mpi::broadcast(&there, sizeof there, root, comm);
    if (!there) {
      one.reset();
      continue;
    }
    if (!one) one.emplace();
    modes::broadcast(one->modes, comm, root);
    std::size_t count = one->truth.size();
    mpi::broadcast(&count, sizeof count, root, comm);
    one->truth.resize(count);
    mpi::broadcast(one->truth.data(), count * sizeof(TrueMode), root, comm);
  }
}

/// Where in a list of the part's surface nodes each of the body's surface nodes is.
std::vector<std::size_t> places_in_part(const mesh::MirroredPart& part,
                                        std::span<const std::int32_t> surface_nodes) {
  std::vector<std::int32_t> own;
  surface_of(part.mesh, own);
  std::vector<std::size_t> place(part.mesh.nodes.size(), 0);
  for (std::size_t k = 0; k < own.size(); ++k) place[static_cast<std::size_t>(own[k])] = k;
  std::vector<std::size_t> out;
  for (const auto n : surface_nodes) {
    const auto node = part.nodes[static_cast<std::size_t>(n)];
    out.push_back(place[static_cast<std::size_t>(node)]);
  }
  return out;
}

/// A mode of a class.
struct Source {
  std::size_t of_class;
  std::size_t mode;
  double eigenvalue;
};

}  // namespace

std::optional<PartToSolve> part_to_solve(const mesh::TetMesh& mesh,
                                         std::span<const elements::Elastic> regions,
                                         const SolveOptions& options, int ranks) {
  if (!options.mirror_planes || options.linear_solver == modes::LinearSolver::iterative ||
      mesh::count_components(mesh) != 1 || 3 * mesh.nodes.size() < min_unknowns) {
    return std::nullopt;
  }
  const auto axes = assembly::mirrored_axes(regions);
  auto part = mesh::mirrored_part(mesh, axes);
  if (!part || 3 * part->mesh.nodes.size() < min_unknowns) return std::nullopt;
  const auto groups = std::min(static_cast<std::size_t>(ranks), part->image_count());
  const double unknowns = 3 * static_cast<double>(part->mesh.nodes.size());
  const double factor = 2 * sizeof(double) * factor_entries * std::pow(unknowns, 4.0 / 3);
  if (2 * factor * static_cast<double>(groups) > static_cast<double>(options.memory_limit)) {
    return std::nullopt;
  }
  PartToSolve out{std::move(*part), {}};
  if (options.estimate_errors) {
    const auto whole = error_margins(mesh, mesh::next_order(mesh));
    out.margins.is_flat = whole.is_flat;
    out.margins.section_fraction = whole.section_fraction;
    for (const auto e : out.part.elements)
      out.margins.at_edges.push_back(whole.at_edges[static_cast<std::size_t>(e)]);
  }
  return out;
}

std::vector<std::optional<modes::Modes>> solve_classes(
    const mesh::TetMesh& mesh, const PartToSolve& body, std::span<const modes::Band> bands,
    const SolveOptions& options, const SolveClass& solve_class, MPI_Comm comm) {
  const auto classes = assembly::mirror_classes(body.part);
  const Groups groups(classes.size(), comm);
  SolveOptions limits = options;
  limits.memory_limit /= static_cast<std::int64_t>(groups.count());
  limits.linear_solver = modes::LinearSolver::direct;
  std::vector<std::vector<modes::Band>> asked(classes.size(), {bands.begin(), bands.end()});
  for (auto& of_class : asked) {
    for (auto& band : of_class) {
      const double share = share_excess * band.max_modes / static_cast<double>(classes.size());
      band.max_modes = std::min(band.max_modes, static_cast<int>(std::ceil(share))) + share_spare;
    }
  }

  std::vector<std::vector<std::optional<ClassModes>>> solved(classes.size());
  std::vector<bool> is_wanted(classes.size(), true);
  std::vector<std::optional<modes::Modes>> out(bands.size());
  for (int round = 0; round < max_requests; ++round) {
    mpi::agreed(comm, [&] {
      for (std::size_t c = 0; c < classes.size(); ++c) {
        if (!is_wanted[c] || !groups.solves(c)) continue;
        solved[c] = solve_class(classes[c], asked[c], limits, groups.comm());
      }
    });
    for (std::size_t c = 0; c < classes.size(); ++c) {
      if (is_wanted[c]) broadcast(solved[c], bands.size(), groups.root(c), comm);
    }
    is_wanted.assign(classes.size(), false);
    for (std::size_t b = 0; b < bands.size(); ++b) {
      if (out[b] || !std::all_of(solved.begin(), solved.end(),
                                 [b](const auto& of_class) { return of_class[b].has_value(); })) {
        continue;
      }
      std::vector<ClassModes> of_band;
      for (const auto& of_class : solved) of_band.push_back(*of_class[b]);
      if (is_enough(of_band, bands[b])) {
        out[b] = join_classes(mesh, body.part, of_band, bands[b]);
        continue;
      }
      const auto shares = further_shares(of_band, bands[b]);
      for (std::size_t c = 0; c < classes.size(); ++c) {
        if (shares[c] == 0) continue;
        is_wanted[c] = true;
        asked[c][b].max_modes = std::min(bands[b].max_modes + share_spare,
                                         std::max(shares[c], asked[c][b].max_modes + share_spare));
      }
    }
    if (std::none_of(is_wanted.begin(), is_wanted.end(), [](bool wanted) { return wanted; })) break;
  }
  return out;
}

modes::Modes join_classes(const mesh::TetMesh& mesh, const mesh::MirroredPart& part,
                          std::span<const ClassModes> classes, const modes::Band& band) {
  const auto mirrors = assembly::mirror_classes(part);
  std::vector<Source> sources;
  std::vector<TrueMode> truth;
  bool complete = true;
  modes::Modes out;
  auto& certificate = out.certificate;
  certificate = classes.front().modes.certificate;
  certificate.modes_in_band = certificate.unknowns = certificate.rigid_modes = 0;
  for (std::size_t c = 0; c < classes.size(); ++c) {
    const auto& modes = classes[c].modes;
    for (std::size_t k = 0; k < modes.size(); ++k) sources.push_back({c, k, modes.eigenvalues[k]});
    truth.insert(truth.end(), classes[c].truth.begin(), classes[c].truth.end());
    const auto& own = modes.certificate;
    complete = complete && own.complete;
    certificate.modes_in_band += own.modes_in_band;
    certificate.unknowns += own.unknowns;
    certificate.rigid_modes += own.rigid_modes;
    certificate.orthonormality = std::max(certificate.orthonormality, own.orthonormality);
    certificate.count_verified = certificate.count_verified && own.count_verified;
    certificate.basis_error = std::max(certificate.basis_error, own.basis_error);
    if (own.eigen_solver != modes::EigenSolver::dense) certificate.eigen_solver = own.eigen_solver;
  }
  certificate.mirror_planes = static_cast<int>(part.planes.size());
  std::stable_sort(sources.begin(), sources.end(),
                   [](const Source& a, const Source& b) { return a.eigenvalue < b.eigenvalue; });
  std::vector<double> ascending;
  auto maximum = static_cast<std::size_t>(band.max_modes);
  for (const auto& source : sources) {
    ascending.push_back(source.eigenvalue);
    maximum += std::sqrt(source.eigenvalue) < 2 * std::numbers::pi * band.bottom();
  }
  std::vector<double> errors;
  if (!truth.empty()) errors = pitch_errors(ascending, std::move(truth));
  const auto count = modes::whole_clusters(ascending, maximum);

  std::vector<std::int32_t> surface_nodes;
  out.surface = surface_of(mesh, surface_nodes);
  const auto places = places_in_part(part, surface_nodes);
  const auto rows = static_cast<Eigen::Index>(count);
  modes::ModeShapes::Rows shapes(rows, 3 * static_cast<Eigen::Index>(surface_nodes.size()));
  const auto regions = classes.front().modes.kinetic_fraction.cols();
  out.kinetic_fraction.resize(rows, regions);
  out.strain_fraction.resize(rows, regions);
  out.mass = classes.front().modes.mass * static_cast<double>(part.image_count());
  const double normalised = 1 / std::sqrt(static_cast<double>(part.image_count()));
  Eigen::VectorXd shape(shapes.cols());
  for (Eigen::Index row = 0; row < rows; ++row) {
    const auto& source = sources[static_cast<std::size_t>(row)];
    const auto& from = classes[source.of_class].modes;
    const auto mode = static_cast<Eigen::Index>(source.mode);
    const Eigen::VectorXd in_part = from.shapes.of(mode);
    for (std::size_t n = 0; n < surface_nodes.size(); ++n) {
      const auto image = part.images[static_cast<std::size_t>(surface_nodes[n])];
      for (int i = 0; i < 3; ++i) {
        shape[3 * static_cast<Eigen::Index>(n) + i] =
            mirrors[source.of_class].sign(image, i) *
            in_part[3 * static_cast<Eigen::Index>(places[n]) + i];
      }
    }
    shapes.row(row) = (normalised * leading_sign(shape) * shape).cast<float>().transpose();
    out.eigenvalues.push_back(source.eigenvalue);
    out.residuals.push_back(from.residuals[source.mode]);
    if (!errors.empty()) out.pitch_errors.push_back(errors[static_cast<std::size_t>(row)]);
    out.kinetic_fraction.row(row) = from.kinetic_fraction.row(mode);
    out.strain_fraction.row(row) = from.strain_fraction.row(mode);
  }
  out.shapes = modes::ModeShapes(std::move(shapes));

  certificate.modes_found = static_cast<std::int64_t>(count);
  certificate.max_residual =
      out.residuals.empty() ? 0 : *std::max_element(out.residuals.begin(), out.residuals.end());
  certificate.complete = complete && count == sources.size();
  certificate.complete_to_hz = known_to(classes);
  if (count < sources.size()) {
    const double next = std::sqrt(sources[count].eigenvalue) / (2 * std::numbers::pi);
    const double last = count > 0 ? out.frequency(count - 1) : next;
    certificate.complete_to_hz = std::min(certificate.complete_to_hz, (last + next) / 2);
  }
  return out;
}

}  // namespace carillon::solvers::eigen
