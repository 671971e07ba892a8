#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "cli/command_line.hpp"
#include "cli/object_options.hpp"
#include "cli/option_values.hpp"
#include "cli/pitch_report.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "eval/damping/law_text.hpp"
#include "eval/recorded_objects/impact_report.hpp"
#include "eval/scripts/run_script.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

namespace {

struct ImpactOptions {
  ObjectOptions object;
  std::string folder, mesh;
  std::string listener = "nearest";
  std::vector<std::int64_t> vertices;
  std::string radiation = "equivalent_sources";
  std::string recordings;
  std::string contact_time;
  std::string metric = "pitches";
  std::string model = "rayleigh", estimator;
  std::string sample_rate = "48 kHz", skip = "1 ms", stretch = "30,3000";
  bool no_fit = false;
  eval::recorded_objects::StudyOptions study;
  std::string output;
};

constexpr double longest_contact = 0.1;  // s

/// The material of the object's name, where none is given.
/// @throws InputError  its name says none
void name_by_folder(ObjectOptions& object, const std::string& name, const Context& context) {
  if (!object.material.empty()) return;
  object.material = eval::recorded_objects::material_in_name(name);
  if (object.material.empty()) {
    throw core::InputError(
        fmt::format("{}: the name does not say what the object is made of", name),
        "add --material NAME (carillon list materials)");
  }
  if (context.speaks() && !context.json) {
    fmt::print("material: {}, as the object's name has it; --material takes another\n",
               object.material);
  }
}

/// "FIRST,END", counted at 48 kHz, in samples of another rate [Hz].
eval::recorded::Stretch parse_stretch(const std::string& text, double sample_rate) {
  constexpr double counted_at = 48000;  // Hz, of the dataset and of Hiner's numbers
  constexpr double longest = 1e8;
  constexpr std::size_t fewest = 16;  // that a spectrum with peaks is made of
  const std::size_t comma = std::min(text.find(','), text.size());
  const auto sample = [&](const std::string& number) {
    const double value = core::parse_quantity(number, core::Dimension::none);
    if (!(value >= 0 && value <= longest)) {
      throw core::InputError(fmt::format("--stretch {}: not samples of a recording", text));
    }
    return static_cast<std::size_t>(std::lround(value * sample_rate / counted_at));
  };
  if (comma == text.size()) {
    throw core::InputError(fmt::format("--stretch {}: FIRST,END is expected", text),
                           "as in 30,3000");
  }
  const eval::recorded::Stretch stretch{sample(text.substr(0, comma)),
                                        sample(text.substr(comma + 1))};
  if (stretch.end < stretch.first + fewest) {
    throw core::InputError(fmt::format("--stretch {} is of fewer than {} samples", text, fewest));
  }
  return stretch;
}

eval::recorded_objects::StudyOptions study_options(const ImpactOptions& options,
                                                   const solvers::modes::Band& band) {
  eval::recorded_objects::StudyOptions study = options.study;
  study.sample_rate =
      option_quantity(options.sample_rate, core::Dimension::frequency, "--sample-rate");
  study.skip = option_quantity(options.skip, core::Dimension::time, "--skip");
  if (!(study.sample_rate >= 1000)) throw core::InputError("--sample-rate must be 1 kHz or more");
  if (!(study.skip >= 0)) throw core::InputError("--skip must not be negative");
  study.stretch = parse_stretch(options.stretch, study.sample_rate);
  study.radiation = options.radiation != "off";
  study.law = eval::damping::damping_law(options.model);
  if (!options.estimator.empty()) {
    study.estimator = eval::damping::estimator_named(options.estimator);
  }
  study.metric = options.metric == "hybrid" ? eval::recorded_objects::StudyMetric::hybrid
                                            : eval::recorded_objects::StudyMetric::pitches;
  if (!options.contact_time.empty()) {
    study.contact_time =
        option_quantity(options.contact_time, core::Dimension::time, "--contact-time");
    if (!(*study.contact_time >= 0 && *study.contact_time <= longest_contact)) {
      throw core::InputError("--contact-time must be 0 to 100 ms");
    }
  }
  study.min_frequency = band.min_frequency;
  study.max_frequency = std::min(band.max_frequency, 0.475 * study.sample_rate);
  return study;
}

void run_realimpact(const ImpactOptions& options, Context& context) {
  eval::recorded_objects::StudyOptions how;
  const eval::recorded_objects::ListenerChoice choice =
      eval::recorded_objects::parse_listener_choice(options.listener);
  std::optional<eval::recorded_objects::ImpactFolder> folder;
  std::vector<eval::recorded_objects::RecordedStrike> rows;
  scene::ObjectRequest object;
  mpi::agreed(context.world, [&] {
    folder = eval::recorded_objects::read_impact_folder(options.folder, options.mesh,
                                                        options.recordings);
    ObjectOptions named = options.object;
    named.mesh = folder->mesh.string();
    name_by_folder(named, folder->name, context);
    object = object_request(named);
    how = study_options(options, object.solve.band);
    rows = eval::recorded_objects::choose_rows(*folder, choice, options.vertices);
  });
  require_output_folder(context, options.output);
  const scene::SolvedObject solved = scene::solve_object(object, context.world, context.cache);
  settle(options.object, solved.pitch_target, context);
  if (!context.speaks()) return;
  const eval::recorded_objects::ImpactReport report = eval::recorded_objects::study_object(
      *folder, rows, solved, how, !options.no_fit, context.cache);
  if (!options.output.empty()) {
    eval::recorded_objects::write_report(options.output, report);
    const std::string none = eval::scripts::draw_picture(
        "plot_realimpact", std::filesystem::path(options.output) / "report.json");
    if (!none.empty()) fmt::print(stderr, "carillon: {}\n", none);
  }
  if (report.fit && !report.fit->specific_modulus) context.exit_code = mpi::exit_failures;
  if (context.json) {
    fmt::print("{}\n", eval::recorded_objects::to_json(report).dump(2));
  } else {
    eval::recorded_objects::print_report(report);
  }
}

void add_study_options(Command& command, ImpactOptions& options) {
  command
      .option("--listener", options.listener,
              "microphone: nearest to the object; angle=80,distance=333,mic=8 (degrees, mm; the "
              "nearest of what is left open); or the number of a row among those of a vertex")
      .show_default();
  command.option("--vertex", options.vertices, "only strikes on this vertex; may be repeated")
      .one_value_each();
  command
      .option("--radiation", options.radiation,
              "equivalent_sources: pressure at the microphone; off: acceleration of the struck "
              "point, as a contact microphone takes it")
      .one_of({"equivalent_sources", "off"})
      .show_default();
  command.option("--recordings", options.recordings,
                 "array of the folder that is compared (default: deconvolved_0db.npy, or "
                 "sounds_0db.npy where that is missing); one whose name does not begin with "
                 "\"deconvolved\" is as it was recorded: the touch and the contact time are those "
                 "of hammer_newtons.npy or hammers.npy, else the onset is found");
  command.option("--contact-time", options.contact_time,
                 "of the hammer, as a raised cosine (default: its recorded force's; without one an "
                 "ideal impulse)");
  command.flag("--no-fit", options.no_fit, "compare the material as given alone");
  command
      .option("--modulus-range", options.study.modulus_range,
              "the fitted specific modulus is at most so many times more or less than the one "
              "given")
      .range(1.01, 1000.0)
      .show_default();
  command
      .option(
          "--metric", options.metric,
          "what the modulus is found by: pitches: frequencies alone, with an interval, wherever "
          "levels come from; hybrid: the papers', spectrograms and match ratios")
      .one_of({"pitches", "hybrid"})
      .show_default();
  command
      .option("--model", options.model,
              "damping that is fitted: rayleigh, caughey, power, hybrid, or a formula")
      .show_default();
  command.option(
      "--estimator", options.estimator,
      "of the damping: mixture, emg, emg_relative, least_squares or lower_bound (default: "
      "emg_relative from ten matched modes more than parameters on, else least squares of "
      "the logarithms)");
  command
      .option("--peaks", options.study.peaks,
              "lowest modes, compared with as many of the highest peaks")
      .range(1, 1000)
      .show_default();
  command.option("--widest", options.study.widest, "modes further apart are not the same [cents]")
      .range(0.1, 150.0)
      .show_default();
  command
      .option("--min-level", options.study.min_level,
              "energy of a mode against the strongest's, at least [dB]")
      .range(-140.0, 0.0)
      .show_default();
  command
      .option("--skip", options.skip,
              "left out of modal features after the sound's arrival at the microphone")
      .show_default();
  command
      .option("--stretch", options.stretch,
              "FIRST,END: samples whose peaks are compared, counted at 48 kHz whatever the "
              "rate is")
      .show_default();
  command.option("--sample-rate", options.sample_rate, "of the recordings; no file says it")
      .show_default();
}

}  // namespace

void add_realimpact(Program& program, Context& context) {
  Command& command =
      program.add("realimpact",
                  "recorded strikes on an object, in RealImpact's folder layout, and what the "
                  "model makes of them",
                  Needs::solver);
  auto options = std::make_shared<ImpactOptions>();
  add_object_options(command, options->object);
  // The folder has the mesh, and in metres.
  command.remove("mesh");
  command.remove("--length");
  command.option_named("--material").show_default("as the object's name has it");
  command.option("folder", options->folder, "of one object, as dataset/22_Cup").required();
  command.option("--mesh", options->mesh,
                 "solved in place of transformed.obj, in the same coordinates");
  add_study_options(command, *options);
  command.option("-o,--output", options->output,
                 "folder for report.json, modes.csv, spectra.csv, spectra.png and sounds");
  command.footer(
      "Examples:\n"
      "  carillon realimpact dataset/22_Cup -m ceramic\n"
      "  carillon realimpact dataset/17_IronSkillet --recordings sounds_0db.npy\n"
      "  carillon realimpact dataset/17_IronSkillet --listener angle=80,distance=333,mic=8 "
      "-o skillet\n"
      "  carillon realimpact dataset/27_WoodPlate -m wood --no-fit --radiation off\n"
      "What is compared, and which levels mean something: docs/realimpact.md");
  command.does([&context, options] { run_realimpact(*options, context); });
}

}  // namespace carillon::cli
