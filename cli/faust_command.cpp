#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "cli/command_line.hpp"
#include "cli/object_options.hpp"
#include "cli/option_values.hpp"
#include "cli/pitch_report.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/revision.hpp"
#include "core/units.hpp"
#include "dataset/exporters/faust_program.hpp"
#include "scene/strikes.hpp"
#include "synth/modal/modal_response.hpp"
#include "synth/modal/row_response.hpp"

namespace carillon::cli {

namespace {

struct FaustOptions {
  ObjectOptions object;
  std::vector<std::string> at;
  std::size_t points = 0;  ///< spread over the surface, in place of `at`
  std::uint64_t seed = 1;
  std::string impulse = scene::default_impulse;
  std::string contact_time = scene::default_contact_time;
  double gain = 1;
  std::size_t loudest = 0;        ///< modes that are kept; 0: all
  std::optional<int> pitch_mode;  ///< that sounds at `freq`, from 1 on
  std::string output;
};

double positive(const std::string& text, core::Dimension dimension, const char* option,
                const char* hint) {
  const double value = option_quantity(text, dimension, option);
  if (!(value > 0)) throw core::InputError(fmt::format("{} {}: not positive", option, text), hint);
  return value;
}

std::vector<synth::modal::SurfacePoint> points_of(const FaustOptions& options,
                                                  const solvers::modes::ModeSurface& surface) {
  const synth::modal::SurfaceSampler sampler(surface);
  core::RandomStream places = scene::strike_places(options.seed);
  if (options.points > 0) return scene::spread_points(sampler, surface, options.points, places);
  if (options.at.empty()) return {sampler.sample(places)};
  std::vector<synth::modal::SurfacePoint> points;
  for (const std::string& at : options.at) {
    points.push_back(scene::nearest_point(sampler, surface, parse_position(at, "--at")));
  }
  return points;
}

/// Modes at the points of a program, as `strike` would sound them.
struct PointModes {
  Eigen::MatrixXd gains;         ///< modes x points [m/s per N s]
  std::vector<double> loudness;  ///< mean square over 200 ms after the strike, loudest point
};

/// Mean square of a mode after the contact, over the 0.2 s over which the ear integrates a tone's
/// energy (Zwicker and Fastl 2007, section 4.4); 0 where it hardly oscillates.
double loudness(double eigenvalue, double decay_rate, double contact_time,
                const synth::modal::Weights& weights) {
  constexpr double integration = 0.2;
  const synth::modal::ModalResponse mode(eigenvalue, decay_rate, contact_time);
  if (mode.damped_frequency() == 0 || mode.near_critical() || !weights.any()) return 0;
  const double rate = 2 * decay_rate;
  const double seconds = rate > 0 ? -std::expm1(-rate * integration) / rate : integration;
  return std::norm(mode.partials(weights)[0].amplitude) / 2 * seconds / integration;
}

PointModes modes_at(const scene::SolvedObject& object, std::span<const double> rates,
                    std::span<const synth::modal::SurfacePoint> points, double contact_time) {
  const auto modes = static_cast<Eigen::Index>(object.modes.size());
  PointModes result{Eigen::MatrixXd(modes, static_cast<Eigen::Index>(points.size())),
                    std::vector<double>(object.modes.size(), 0.0)};
  for (std::size_t p = 0; p < points.size(); ++p) {
    synth::modal::Strike strike;
    strike.point = points[p];
    strike.direction = -synth::modal::frame_at(object.modes.surface, points[p]).normal;
    strike.impulse = 1;
    strike.force.duration = contact_time;
    const synth::modal::RingDown rings = synth::modal::ring_down(
        object.modes, rates, strike, synth::modal::point_velocity(object.modes, points[p]));
    result.gains.col(static_cast<Eigen::Index>(p)) =
        rings.excitation.cwiseProduct(rings.readout.velocity.row(0).transpose());
    for (std::size_t i = 0; i < rates.size(); ++i) {
      const auto weights = synth::modal::weights_of(rings.readout, 0, static_cast<Eigen::Index>(i),
                                                    rings.excitation[static_cast<Eigen::Index>(i)]);
      result.loudness[i] =
          std::max(result.loudness[i],
                   loudness(rings.eigenvalues[i], rings.decay_rates[i], contact_time, weights));
    }
  }
  return result;
}

/// The loudest modes, in the order of their frequencies.
std::vector<std::size_t> loudest(std::span<const double> loudness, std::size_t maximum) {
  std::vector<std::size_t> order(loudness.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (maximum == 0 || maximum >= order.size()) return order;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return loudness[a] > loudness[b]; });
  order.resize(maximum);
  std::sort(order.begin(), order.end());
  return order;
}

/// The mode that a note's `freq` is the pitch of: the one that is named, else the lowest that is
/// audible, within 40 dB of the loudest.
std::size_t pitch_mode(const FaustOptions& options, std::span<const double> loudness) {
  if (options.pitch_mode) {
    const auto mode = static_cast<std::size_t>(*options.pitch_mode);
    if (mode <= loudness.size()) return mode - 1;
    throw core::InputError(fmt::format("--pitch-mode {}: {} has {} modes in the band", mode,
                                       options.object.mesh, loudness.size()),
                           "carillon modes lists them by their numbers");
  }
  constexpr double audible = 1e-4;
  const double loudest = *std::max_element(loudness.begin(), loudness.end());
  return static_cast<std::size_t>(
      std::find_if(loudness.begin(), loudness.end(),
                   [&](double one) { return one >= audible * loudest; }) -
      loudness.begin());
}

/// What the header says of where the program comes from.
std::vector<std::string> remarks(const scene::SolvedObject& object, const FaustOptions& options,
                                 const dataset::exporters::FaustProgram& program,
                                 const Context& context) {
  const solvers::modes::Certificate& certificate = object.modes.certificate;
  std::vector<std::string> lines = {fmt::format("Made by Carillon {}:", core::version()),
                                    context.command, ""};
  for (const synth::material::Material& material : object.materials) {
    lines.push_back(fmt::format("Material {}: {:.6g} Pa, Poisson's ratio {:.4g}, {:.6g} kg/m^3; {}",
                                material.name, material.elastic.youngs_modulus,
                                material.elastic.poisson_ratio, material.elastic.density,
                                synth::damping::formula_of(material.damping)));
  }
  lines.push_back(fmt::format("Mass {:.6g} kg.", object.modes.mass));
  lines.push_back(fmt::format("{} modes{}; {} of the {} from {:.6g} to {:.6g} Hz were found{}.",
                              program.modes.size(), options.loudest == 0 ? "" : ", the loudest",
                              certificate.modes_found, certificate.modes_in_band,
                              certificate.min_frequency, certificate.max_frequency,
                              certificate.count_verified ? ", counted by inertia" : ""));
  lines.push_back(fmt::format("Complete to {:.6g} Hz; worst residual {:.1e}.",
                              certificate.complete_to_hz, certificate.max_residual));
  lines.push_back(fmt::format("Own pitch {:.6g} Hz.", program.own_pitch));
  for (std::size_t p = 0; p < program.points.size(); ++p) {
    const Vec3& at = program.points[p];
    lines.push_back(fmt::format("Vertex {}: {:.6g}, {:.6g}, {:.6g} m.", p, at.x(), at.y(), at.z()));
  }
  return lines;
}

dataset::exporters::FaustProgram program_of(const scene::SolvedObject& object,
                                            const FaustOptions& options, const Context& context) {
  if (object.modes.size() == 0) {
    throw core::InputError(
        fmt::format("{} has no mode between {:.6g} and {:.6g} Hz", options.object.mesh,
                    object.modes.certificate.min_frequency, object.modes.certificate.max_frequency),
        "carillon modes says where its first one is expected; widen the band");
  }
  dataset::exporters::FaustProgram program;
  program.name = fmt::format("{}, {}", options.object.mesh, options.object.material);
  program.impulse = core::parse_quantity(options.impulse, core::Dimension::impulse);
  program.contact_time = core::parse_quantity(options.contact_time, core::Dimension::time);
  program.gain = options.gain;
  const std::vector<double> rates =
      synth::damping::decay_rates(object.modes, scene::damping_of(object.materials));
  const auto points = points_of(options, object.modes.surface);
  for (const synth::modal::SurfacePoint& point : points) {
    program.points.push_back(synth::modal::frame_at(object.modes.surface, point).position);
  }
  const PointModes at = modes_at(object, rates, points, program.contact_time);
  const dataset::exporters::FaustDamping damping =
      dataset::exporters::faust_damping(object.modes, object.materials, rates);
  program.damping = damping.definitions;
  for (const auto& column : damping.columns) program.damping_columns.push_back(column.name);
  program.own_pitch = object.modes.frequency(pitch_mode(options, at.loudness));
  for (const std::size_t i : loudest(at.loudness, options.loudest)) {
    const Eigen::VectorXd gains = at.gains.row(static_cast<Eigen::Index>(i));
    std::vector<double> of_damping;
    for (const auto& column : damping.columns) of_damping.push_back(column.values[i]);
    program.modes.push_back(
        {object.modes.eigenvalues[i],
         of_damping,
         {gains.begin(), gains.end()},
         fmt::format("{:.2f} Hz, {:.4g} 1/s", object.modes.frequency(i), rates[i])});
  }
  program.remarks = remarks(object, options, program, context);
  return program;
}

/// Everything that is wrong without knowing the object, before it is solved.
void check_options(const FaustOptions& options) {
  if (!options.at.empty() && options.points > 0) {
    throw core::InputError("--at and --points both say where", "give one of them");
  }
  positive(options.impulse, core::Dimension::impulse, "--impulse", "it is the strike's at first");
  const double contact = positive(
      options.contact_time, core::Dimension::time, "--contact-time",
      "an ideal impulse of 1 N s is one sample of the program's input, as high as its rate");
  if (contact < dataset::exporters::shortest_contact ||
      contact > dataset::exporters::longest_contact) {
    throw core::InputError(fmt::format("--contact-time {}: the program's strikes last 1 us to 1 s",
                                       options.contact_time));
  }
  if (!(options.gain > 0)) throw core::InputError("--gain is not positive");
}

void run_export_faust(FaustOptions options, Context& context) {
  check_options(options);
  name_material(options.object, context);
  require_output_file(context, options.output);
  const scene::SolvedObject object = solve_object(options.object, context);
  settle(options.object, object.pitch_target, context);
  if (!context.speaks()) return;
  const dataset::exporters::FaustProgram program = program_of(object, options, context);
  core::write_text_durably(options.output, dataset::exporters::faust_text(program));
  const std::size_t left_out = object.modes.size() - program.modes.size();
  if (context.json) {
    nlohmann::json points = nlohmann::json::array();
    for (const Vec3& at : program.points) points.push_back({at.x(), at.y(), at.z()});
    fmt::print("{}\n", nlohmann::json{{"file", options.output},
                                      {"modes", program.modes.size()},
                                      {"modes_left_out", left_out},
                                      {"pitch_hz", program.own_pitch},
                                      {"latency_samples", program.modes.size()},
                                      {"positions_m", points}}
                           .dump(2));
    return;
  }
  fmt::print("{}: {} modes at {} point{}, {:.6g} Hz\n", options.output, program.modes.size(),
             program.points.size(), program.points.size() == 1 ? "" : "s", program.own_pitch);
  if (left_out > 0) fmt::print("{} softer modes left out\n", left_out);
}

}  // namespace

void add_export_faust(Program& program, Context& context) {
  Command& command =
      program.add("export-faust", "an object as an instrument with MIDI notes: a program in Faust",
                  Needs::solver);
  auto options = std::make_shared<FaustOptions>();
  add_object_options(command, options->object);
  add_tuning_options(command, options->object);
  command.option("-o,--output", options->output, "Faust program, .dsp").required();
  command
      .option("--at", options->at,
              "point that can be struck, x,y,z [m]; more than one: a vertex each "
              "(default: drawn by --seed)")
      .one_value_each();
  command.option("--points", options->points, "so many points, far from each other").range(1, 1000);
  command.option("--seed", options->seed, "of points that are drawn").show_default();
  command
      .option("--loudest", options->loudest,
              "at most so many modes: those with the most energy in the 200 ms after a strike, "
              "at the point where each is loudest (default: all)")
      .range(1, 100000);
  command
      .option("--pitch-mode", options->pitch_mode,
              "mode that sounds at freq, by its number in carillon modes")
      .range(1, 100000)
      .show_default("the lowest within 40 dB of the loudest");
  command.option("--impulse", options->impulse, "of a strike, at first").show_default();
  command.option("--contact-time", options->contact_time, "of a strike, at first").show_default();
  command.option("--gain", options->gain, "full scale per m/s, at first: the slider level")
      .show_default();
  command.footer(
      "Examples:\n"
      "  carillon export-faust bowl -m ceramic --points 8 -o bowl.dsp && faust2jaqt -midi -nvoices "
      "8 "
      "bowl.dsp\n"
      "  carillon export-faust bell --at 0.05,0,0.02 --at 0,0,0.09 --loudest 40 -o "
      "bell.dsp\n"
      "docs/exports.md");
  command.does([&context, options] { run_export_faust(*options, context); });
}

}  // namespace carillon::cli
