#include "solvers/pitch/pitch_target.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "core/trace.hpp"
#include "core/units.hpp"
#include "solvers/mesh/grade_to_edges.hpp"
#include "solvers/pitch/pitch_model.hpp"

namespace carillon::solvers::pitch {
namespace {

/// [semitones] Modes are seldom more than this too sharp where a target is nearly met.
constexpr double judged_above = 2;
constexpr std::size_t max_steps = 8;
/// Work of a step may be so much more than that of the best one so far: predictions far away are
/// not to be trusted with hours.
constexpr double max_growth = 40;
/// What stands, times the target, for the error of modes that were not found.
constexpr double unknown = 30;
/// An error that falls by less than this factor has not moved.
constexpr double min_gain = 0.9;
/// Where a step gains less than this part of what was predicted (in logarithms), inward edges are
/// suspected.
constexpr double poor_gain = 0.6;
constexpr int max_edge_layers = 4;
/// Predictions of another order are right within this factor (predicted_error).
constexpr double order_factor = 2;
/// Meshes that come out larger than the unknowns allowed by more than this are not solved.
constexpr double slack = 1.25;
constexpr int max_refusals = 4;

/// A setting that could come next.
struct Candidate {
  mesh::MeshOptions options;
  MeshSize size;
  double unknowns;
  double error;  ///< predicted [cent]
  double cost;
};

/// What bounds a choice; each can be lifted to see which one stands in the way.
struct Bounds {
  double elements;
  double memory;
  double cost;
  double unknowns;
};

class Search {
 public:
  Search(const PitchTarget& target, const MeshMaker& make_mesh, const ModeSolver& solve,
         const ModeSolver& probe)
      : target_(target), make_mesh_(make_mesh), solve_(solve), probe_(probe) {
    result_.report.asked_cents = target.cents;
    edge_layers_ = target.start.edge_layers;
  }

  PitchResult run() {
    refine();
    if (result_.sets.empty()) {
      result_.sets = solve_(result_.mesh);
      PitchStep& chosen = report().steps[report().chosen];
      note_errors(result_.sets, chosen);
      report().reached_cents = chosen.worst_cents;
    }
    return std::move(result_);
  }

 private:
  void refine() {
    mesh::MeshOptions options = target_.start;
    while (true) {
      attempt(options);
      if (met() || failed()) return;
      const auto next = choose();
      if (!next) return;
      planned_ = next->size;
      options = next->options;
    }
  }

  PitchReport& report() { return result_.report; }
  double needed() const { return std::max(trusted_share * target_.cents, min_pitch_target); }
  bool met() { return report().reached_cents <= needed() && report().stopped_by.empty(); }
  bool failed() { return !report().stopped_by.empty(); }

  void stop(const std::string& by, const std::string& reason) {
    report().stopped_by = by;
    report().reason = reason;
    if (report().reached_cents <= target_.cents)
      report().reason += fmt::format(
          "; estimates may be a fifth too low, so {:.3g} cents is not taken for certain",
          report().reached_cents);
  }

  void stop_without_progress() {
    stop("no_progress",
         fmt::format("two refinements did not bring the worst mode below {:.3g} cents",
                     report().reached_cents));
  }

  /// The step that solved these elements already; null when there is none.
  const PitchStep* step_with(const mesh::TetMesh& mesh) const {
    const auto& steps = result_.report.steps;
    const auto found = std::find_if(steps.begin(), steps.end(), [&mesh](const PitchStep& step) {
      return step.order == mesh.order &&
             step.elements == static_cast<std::int64_t>(mesh.element_count()) &&
             step.unknowns == 3 * static_cast<std::int64_t>(mesh.nodes.size());
    });
    return found == steps.end() ? nullptr : &*found;
  }

  void stop_at_unknowns() {
    stop("max_unknowns", fmt::format("the next refinement needs more than the {} unknowns allowed",
                                     target_.max_unknowns));
  }

  /// Tries a setting, or notes why it cannot be had.
  void attempt(const mesh::MeshOptions& options) {
    const bool first = report().steps.empty();
    const double start = core::monotonic_seconds();
    mesh::MeshResult mesh;
    try {
      mesh = make_mesh_(options);
    } catch (const core::ResourceError&) {
      throw;  // another machine might go on: what comes out must not hang on that
    } catch (const core::LimitError& error) {
      if (first) throw;
      // This costs little, and fewer elements will do.
      element_share_ /= 2;
      if (++refused_ == max_refusals) stop("max_elements", error.message());
      return;
    } catch (const core::SolverError& error) {
      if (first) throw;
      stop("mesher", error.message());
      return;
    }
    const double unknowns = 3.0 * static_cast<double>(mesh.mesh.nodes.size());
    const bool too_large = unknowns > slack * static_cast<double>(target_.max_unknowns);
    if (first && too_large && options.order > 2 && !target_.fixed_mesh) {
      // Detail may take so many elements that their order is all that can be spared.
      mesh::MeshOptions lower = options;
      --lower.order;
      return attempt(lower);
    }
    if (!first && too_large) {
      // Smaller sizes follow more of a surface's detail than sizes foretell.
      excess_ = std::max(excess_, unknowns / planned_.unknowns());
      if (++refused_ == max_refusals) stop_at_unknowns();
      return;
    }
    if (const PitchStep* same = step_with(mesh.mesh); same != nullptr) {
      // More layers than the elements bear were left out by the mesher.
      layers_end_ = layers_end_ || options.edge_layers > same->edge_layers;
      edge_layers_ = same->edge_layers;
      repeating_.push_back(options);
      if (++refused_ == max_refusals) stop_without_progress();
      return;
    }
    PitchStep step;
    std::vector<modes::Modes> sets;
    try {
      if (probe_) note_errors(probe_(mesh), step);
      if (!probe_ || step.worst_cents <= needed()) {
        sets = solve_(mesh);
        note_errors(sets, step);
      }
    } catch (const core::ResourceError&) {
      throw;
    } catch (const core::SolverError& error) {
      if (first) throw;
      stop("solver", error.message());
      return;
    }
    step.seconds = core::monotonic_seconds() - start;
    judge(options, std::move(mesh), std::move(sets), step);
  }

  /// Notes the worst and the median error of all sets together.
  static void note_errors(std::span<const modes::Modes> sets, PitchStep& step) {
    std::vector<double> errors;
    for (const modes::Modes& modes : sets) {
      if (modes.pitch_errors.size() != modes.size()) {
        throw core::InputError("a pitch target needs estimated pitch errors",
                               "solve with estimate_errors");
      }
      errors.insert(errors.end(), modes.pitch_errors.begin(), modes.pitch_errors.end());
      step.unknowns = std::max(step.unknowns, modes.certificate.unknowns);
    }
    step.worst_cents = errors.empty() ? 0 : *std::max_element(errors.begin(), errors.end());
    step.median_cents = core::median(errors);
  }

  /// Notes a step that was solved, and keeps it when it is the best.
  /// @param sets  empty where a probe showed that it falls short
  void judge(const mesh::MeshOptions& options, mesh::MeshResult mesh,
             std::vector<modes::Modes> sets, PitchStep step) {
    // A band may be empty because its modes are far too sharp: a second setting has to agree.
    const bool is_empty = std::isnan(step.median_cents);
    if (is_empty && !was_empty_) step.worst_cents = unknown * target_.cents;
    was_empty_ = is_empty;
    const MeshSize size = size_of(mesh.mesh);
    step.order = mesh.mesh.order;
    step.automatic_size = options.element_size <= 0;
    step.element_size = step.automatic_size ? size.element_size : options.element_size;
    step.edge_layers = options.edge_layers;
    step.elements = static_cast<std::int64_t>(mesh.mesh.element_count());

    auto& steps = report().steps;
    const bool first = steps.empty();
    has_edges_ = !target_.fixed_mesh && mesh::has_edges_to_grade(mesh.mesh);
    const double before = report().reached_cents;
    if (!first) learn(before, step, size);
    if (first && has_edges_) edge_layers_ = std::max(edge_layers_, edge_layers_for(target_.cents));
    if (first || step.worst_cents < before) {
      report().reached_cents = step.worst_cents;
      report().chosen = steps.size();
      best_ = size;
      asked_size_ = step.element_size;
      result_.mesh = std::move(mesh);
      result_.sets = std::move(sets);
    }
    steps.push_back(step);
    if (!met() && stuck_ > 1) {
      stop_without_progress();
    } else if (!met() && steps.size() == max_steps) {
      stop("steps", fmt::format("{} settings were tried", max_steps));
    }
  }

  /// Compares a step with its prediction: where corners or a rough surface slow convergence down,
  /// later predictions promise less. Where fewer elements were made than a size was expected to
  /// give, they promised less themselves, and smaller sizes are asked for from now on; the
  /// automatic size, which is another one for every order, says nothing about those.
  void learn(double before, const PitchStep& step, const MeshSize& made) {
    const double now = step.worst_cents;
    const double coarser = std::sqrt(std::max(1.0, planned_.elements / made.elements));
    double factor = coarser * planned_.element_size / best_.element_size;
    if (step.automatic_size) factor = std::max(factor, made.element_size / best_.element_size);
    if (!step.automatic_size) asked_size_ /= coarser;
    const double promised = std::log(before / predicted(before, planned_.order, factor));
    if (promised < 0.2) return;
    stuck_ = now > min_gain * before ? stuck_ + 1 : 0;
    const double gained = now > 0 ? std::log(before / now) : promised;
    if (gained < poor_gain * promised && has_edges_ && !layers_end_ &&
        edge_layers_ < max_edge_layers) {
      ++edge_layers_;
      return;
    }
    double share = gained / promised;
    // From one order to the next a prediction may be off by its factor, which says nothing of how
    // errors fall with the size.
    if (planned_.order != best_.order && share < 1)
      share = std::min(1.0, (gained + std::log(order_factor)) / promised);
    trust_ = std::clamp(trust_ * share, 0.15, 1.0);
  }

  const PitchStep& best_step() const { return result_.report.steps[result_.report.chosen]; }

  /// The error of another order and size than the best's, whose error is `reached` [cent].
  double predicted(double reached, int order, double size_factor) const {
    return reached *
           std::pow(predicted_error(reached, best_.order, order, size_factor) / reached, trust_);
  }

  std::vector<Candidate> candidates() const {
    std::vector<Candidate> all;
    const double reached = result_.report.reached_cents;
    for (int order = target_.fixed_mesh ? best_.order + 1 : 2; order <= 4; ++order)
      for (int k = finest_sixth; k <= coarsest_sixth; ++k) {
        if (target_.fixed_mesh && k != 0) continue;
        const double factor = std::pow(2, k / 6.0);
        Candidate c;
        c.options = target_.start;
        c.options.order = order;
        c.options.edge_layers = edge_layers_;
        // The automatic size again: it passes over detail that a size would follow.
        const bool automatic = k == 0 && best_step().automatic_size;
        if (!target_.fixed_mesh)
          c.options.element_size = automatic ? target_.start.element_size : asked_size_ * factor;
        c.size = resized(best_, order, factor);
        c.unknowns = c.size.unknowns() * (automatic ? 1 : excess_);
        c.error = predicted(reached, order, factor);
        c.cost = relative_cost(c.size);
        if (!was_tried(c.options)) all.push_back(c);
      }
    return all;
  }

  /// Cells come in whole numbers, on sides that are mirrored in even ones: sizes above one that
  /// made the elements of another step make them, too, or coarser ones.
  bool would_repeat(const mesh::MeshOptions& options) const {
    return std::any_of(repeating_.begin(), repeating_.end(), [&](const mesh::MeshOptions& other) {
      return other.order == options.order && other.edge_layers == options.edge_layers &&
             options.element_size > 0.98 * other.element_size && other.element_size > 0;
    });
  }

  bool was_tried(const mesh::MeshOptions& options) const {
    if (would_repeat(options)) return true;
    const auto& steps = result_.report.steps;
    return std::any_of(steps.begin(), steps.end(), [&](const PitchStep& step) {
      return step.order == options.order && step.edge_layers == options.edge_layers &&
             (target_.fixed_mesh || (options.element_size <= 0 && step.automatic_size) ||
              std::abs(step.element_size / options.element_size - 1) < 0.02);
    });
  }

  /// The cheapest within bounds that should do; else the most accurate within them.
  static const Candidate* best_of(const std::vector<Candidate>& all, const Bounds& bounds,
                                  double goal) {
    const Candidate* best = nullptr;
    for (const Candidate& c : all) {
      if (c.size.elements > bounds.elements || factor_memory(c.size) > bounds.memory ||
          c.cost > bounds.cost || c.unknowns > bounds.unknowns)
        continue;
      if (best == nullptr || is_better(c, *best, goal)) best = &c;
    }
    return best;
  }

  static bool is_better(const Candidate& one, const Candidate& other, double goal) {
    if (one.error > goal && other.error > goal) return one.error < other.error;
    return one.error <= goal && (other.error > goal || one.cost < other.cost);
  }

  std::optional<Candidate> choose() {
    const double reached = report().reached_cents;
    const double goal = aimed_error(target_.cents, reached);
    const auto all = candidates();
    constexpr double none = 1e300;
    // Meshers end up to a tenth above what is asked for, and more where a wall takes a second
    // layer.
    Bounds bounds{0.9 * element_share_ * static_cast<double>(target_.start.max_elements),
                  target_.linear_solver == modes::LinearSolver::iterative
                      ? none
                      : static_cast<double>(target_.memory_limit),
                  max_growth * relative_cost(best_), static_cast<double>(target_.max_unknowns)};
    const Candidate* next = best_of(all, bounds, goal);
    if (next != nullptr && (next->error <= goal || next->error < 0.8 * reached)) return *next;

    const auto helps = [&](Bounds lifted) {
      const Candidate* other = best_of(all, lifted, goal);
      return other != nullptr && other->error < 0.8 * reached;
    };
    if (target_.fixed_mesh && all.empty()) {
      stop("order", "the given elements are of order 4, the highest, and cannot be refined");
    } else if (helps({bounds.elements, bounds.memory, bounds.cost, none})) {
      stop_at_unknowns();
    } else if (helps({none, bounds.memory, bounds.cost, none})) {
      stop("max_elements",
           fmt::format("the next refinement needs more than the {} elements allowed",
                       target_.start.max_elements));
    } else if (helps({bounds.elements, none, bounds.cost, none})) {
      stop("memory_limit",
           fmt::format("the factor of the next refinement needs more than the {:.3g} GiB allowed",
                       static_cast<double>(target_.memory_limit) / (1ll << 30)));
    } else if (helps({none, none, bounds.cost, none})) {
      stop("max_elements", fmt::format("the next refinement needs more than the {} elements, and "
                                       "the {:.3g} GiB of factor, allowed",
                                       target_.start.max_elements,
                                       static_cast<double>(target_.memory_limit) / (1ll << 30)));
    } else {
      stop("no_progress", fmt::format("refining by a factor of {} in work would gain nothing that "
                                      "counts",
                                      max_growth));
    }
    return std::nullopt;
  }

  const PitchTarget& target_;
  const MeshMaker& make_mesh_;
  const ModeSolver& solve_;
  const ModeSolver& probe_;
  PitchResult result_;       ///< without sets while its setting was only probed
  MeshSize best_;            ///< mesh of the best step
  double asked_size_ = 0;    ///< and the size it was asked with
  MeshSize planned_;         ///< what the step under way was expected to give
  double trust_ = 1;         ///< fraction of a predicted gain (in logarithms) that comes true
  bool was_empty_ = false;   ///< the last step found no mode
  bool has_edges_ = false;   ///< that layers help
  int edge_layers_ = 0;      ///< of the next step
  bool layers_end_ = false;  ///< more of them are left out
  int stuck_ = 0;            ///< steps in a row that gained nothing
  std::vector<mesh::MeshOptions> repeating_;  ///< settings that made elements of other steps
  int refused_ = 0;                           ///< settings whose elements were not solved
  double element_share_ = 1;                  ///< of the elements allowed that sizes may foretell
  double excess_ = 1;                         ///< of the unknowns of such, over what was predicted
};

}  // namespace

modes::Band judged_band(const modes::Band& band) {
  modes::Band out = band;
  out.max_frequency *= std::exp2(judged_above / 12);
  return out;
}

modes::Modes without_margin(const modes::Modes& modes) {
  const auto& certificate = modes.certificate;
  return modes::restrict_to(
      modes, {certificate.min_frequency, certificate.max_frequency / std::exp2(judged_above / 12),
              std::numeric_limits<int>::max()});
}

double parse_pitch_target(const std::string& text) {
  if (text == "off") return 0;
  const double cents = core::parse_quantity(text, core::Dimension::none);
  if (cents != 0 && !(cents >= min_pitch_target && std::isfinite(cents))) {
    throw core::InputError(fmt::format("a pitch target of {} cents cannot be met", text),
                           fmt::format("{} is the least that estimates can tell; \"off\" takes "
                                       "meshes as they come",
                                       min_pitch_target));
  }
  return cents;
}

PitchResult reach_pitch(const PitchTarget& target, const MeshMaker& make_mesh,
                        const ModeSolver& solve, const ModeSolver& probe) {
  if (!(target.cents >= min_pitch_target) || !std::isfinite(target.cents)) {
    throw core::InputError(
        fmt::format("a pitch target of {} cents cannot be met", target.cents),
        fmt::format("{} is the least that estimates can tell", min_pitch_target));
  }
  return Search(target, make_mesh, solve, probe).run();
}

}  // namespace carillon::solvers::pitch
