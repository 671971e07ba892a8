#include <fmt/format.h>

#include <optional>
#include <vector>

#include "cli/command_line.hpp"
#include "cli/object_options.hpp"
#include "cli/option_values.hpp"
#include "cli/recording.hpp"
#include "core/audio.hpp"
#include "core/files.hpp"
#include "eval/material/estimate_recording.hpp"
#include "eval/material/estimate_report.hpp"
#include "eval/material/pitch_report.hpp"
#include "mpi/comm.hpp"
#include "scene/poisson_sets.hpp"

namespace carillon::cli {

namespace {

struct EstimateOptions {
  ObjectOptions object;
  eval::material::EstimateArguments estimate;
  std::string recording;
  std::vector<std::string> further;
  int channel = 1;
  std::string at, direction;
  std::string output;
};

/// What is known of the strike and of the material, as given.
struct Known {
  eval::material::Metric metric = eval::material::Metric::pitches;
  eval::material::MaterialOptions options;
  synth::material::Material assumed;
  std::vector<double> poisson_ratios;
  std::optional<eval::material::StruckPlace> place;
  std::optional<double> density;
  scene::ObjectRequest request;
};

Known read_known(const EstimateOptions& options, Context& context) {
  Known known;
  known.metric = eval::material::checked_metric(
      options.estimate, !options.at.empty(), 1 + options.further.size(), !options.output.empty());
  known.options = eval::material::material_options(options.estimate);
  known.assumed = eval::material::assumed_material(options.object.material, options.estimate);
  known.poisson_ratios = eval::material::poisson_ratios(options.object.material, options.estimate);
  known.density = eval::material::known_density(options.estimate);
  mpi::agreed(context.world, [&] { known.request = object_request(options.object); });
  known.request.materials = {{"", known.assumed}};
  std::optional<Vec3> direction;
  if (!options.direction.empty()) direction = parse_position(options.direction, "--direction");
  if (!options.at.empty()) {
    known.place = eval::material::struck_place(parse_position(options.at, "--at"), direction);
    known.request.struck = {known.place->at};
  } else if (direction) {
    throw core::InputError("--direction needs --at");
  }
  require_output_file(context, options.output);
  return known;
}

std::vector<eval::material::HeardRecording> listen_to(const EstimateOptions& options,
                                                      Context& context, core::Trace& trace) {
  std::vector<eval::material::HeardRecording> heard;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    const core::ScopedTimer timer(trace.stages["features"]);
    std::vector<std::string> files = options.further;
    files.insert(files.begin(), options.recording);
    for (const std::string& file : files) {
      ChannelClip clip = read_channel(file, options.channel);
      heard.push_back(eval::material::listen(std::move(clip.samples), clip.sample_rate,
                                             options.estimate, file));
    }
  });
  return heard;
}

void estimate_by_pitches(const EstimateOptions& options, const Known& known, Context& context) {
  core::Trace trace;
  const auto recordings = listen_to(options, context, trace);
  const scene::PoissonSets sets = scene::solve_poisson_ratios(known.request, known.poisson_ratios,
                                                              context.world, context.cache);
  trace.merge(sets.trace);
  bool complete = true;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    const eval::material::PitchEstimate found = eval::material::estimate_from_recordings(
        recordings, sets.modes, sets.poisson_ratios, known.assumed, known.place, known.options.law,
        trace);
    complete = found.complete();
    if (context.json) {
      fmt::print("{}\n", eval::material::to_json(found, known.density, trace).dump(2));
    } else {
      eval::material::print_estimate(found, known.density, trace);
    }
  });
  if (!complete) context.exit_code = mpi::exit_failures;
}

void estimate_by_sound(const EstimateOptions& options, const Known& known, Context& context) {
  core::Trace trace;
  const auto recordings = listen_to(options, context, trace);
  const scene::SolvedObject object =
      scene::solve_object(known.request, context.world, context.cache);
  if (!context.speaks()) return;
  trace.merge(object.trace);
  const eval::material::HeardRecording& recording = recordings.front();
  const eval::material::RecordedMaterial found =
      eval::material::estimate_recording(recording, object.modes, object.materials, *known.place,
                                         known.options, options.object.mesh, trace);
  if (!options.output.empty()) {
    core::write_durably(options.output, [&](const std::filesystem::path& path) {
      core::write_wav(path, found.resynthesis, core::SampleFormat::float32);
    });
  }
  if (context.json) {
    fmt::print(
        "{}\n",
        eval::material::to_json(found.estimate, recording.set, known.density, trace).dump(2));
  } else {
    eval::material::print_estimate(found.estimate, recording.set, known.density, trace);
  }
}

void run_estimate(const EstimateOptions& options, Context& context) {
  const Known known = read_known(options, context);
  if (known.metric == eval::material::Metric::pitches) {
    estimate_by_pitches(options, known, context);
  } else {
    estimate_by_sound(options, known, context);
  }
}

}  // namespace

void add_estimate(Program& program, Context& context) {
  Command& command = program.add(
      "estimate", "material of a struck object from recordings of it and its mesh", Needs::solver);
  auto options = std::make_shared<EstimateOptions>();
  command.option("recording", options->recording, "WAV or any file that libsndfile reads")
      .required();
  add_object_options(command, options->object);
  command.option("further", options->further,
                 "more recordings of the same object, by other strikes or microphones");
  command.option_named("--material")
      .description(
          "assumed material, whose modes are solved once and rescaled: preset or "
          "youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700; its damping is not "
          "used")
      .show_default("70 GPa, 2500 kg/m^3");
  command
      .option("--metric", options->estimate.metric,
              "pitches: frequencies alone, with intervals, wherever it was struck and heard; "
              "hybrid: the papers', spectrograms and match ratios, which needs --at")
      .one_of({"pitches", "hybrid"})
      .show_default();
  command.option("--at", options->at, "point struck, x,y,z [m] (default: unknown)");
  command.option("--direction", options->direction,
                 "way the force points, x,y,z (default: inward along the normal)");
  command.option("--poisson-ratio", options->estimate.poisson_ratio,
                 "of the object (default: the assumed material's; without one all are tried)");
  command.option("--density", options->estimate.density,
                 "of the object; gives Young's modulus, which cannot be heard without it");
  command
      .option("--model", options->estimate.model,
              "rayleigh, caughey, power, hybrid, or a formula of lambda, omega, f and "
              "alpha1, alpha2, ...")
      .show_default();
  command
      .option("--heard", options->estimate.heard,
              "hybrid: motion of the struck point that the recording follows: velocity (strike "
              "without listeners), acceleration (microphones), displacement")
      .show_default();
  command.option("--contact-time", options->estimate.contact_time,
                 "hybrid: duration of the contact; 0: an ideal impulse (default: estimated too)");
  command.option("--channel", options->channel, "of the recording, from 1")
      .range(1, 1000)
      .show_default();
  command.option("--onset", options->estimate.onset,
                 "where the strike begins (default: it is found)");
  command.option(
      "--rt60", options->estimate.rt60,
      "reverberation time of the room, or T1,T2,... by octave from 125 Hz on, 0: none "
      "(default: told by what is heard around the modes): decays that may be its own say "
      "nothing of the damping");
  command
      .option("--starts", options->estimate.starts,
              "hybrid: local searches, from the best start points")
      .range(std::size_t{1}, eval::material::EstimateArguments::max_starts)
      .show_default();
  command.option("--seed", options->estimate.seed, "hybrid: of everything that is drawn")
      .show_default();
  command.option("-o,--output", options->output,
                 "hybrid: WAV file of the estimate, as long and as loud as the recording");
  command.footer(
      "Examples:\n"
      "  carillon strike bowl -m glass --at 0.08,0,0.05 -o bowl.wav\n"
      "  carillon estimate bowl.wav bowl --density 2600\n"
      "  carillon estimate left.wav plate.obj right.wav --length 20cm --poisson-ratio 0.2\n"
      "  carillon estimate bowl.wav bowl --at 0.08,0,0.05 -m ceramic --metric hybrid "
      "--heard acceleration -o again.wav");
  command.does([&context, options] { run_estimate(*options, context); });
}

}  // namespace carillon::cli
