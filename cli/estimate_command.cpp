#include <fmt/format.h>

#include <optional>

#include "cli/command_line.hpp"
#include "cli/feature_options.hpp"
#include "cli/object_options.hpp"
#include "cli/recording.hpp"
#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "eval/damping/law_text.hpp"
#include "eval/material/assumed_material.hpp"
#include "eval/material/estimate_material.hpp"
#include "eval/material/estimate_report.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

namespace {

struct EstimateOptions {
  ObjectOptions object;
  std::string recording;
  int channel = 1;
  std::string at, direction;
  std::string poisson_ratio, density;  ///< "": the assumed material's; density then unknown
  std::string model = "rayleigh";
  std::string heard = "velocity";
  std::string contact_time;  ///< "": sought
  std::string onset, rt60;
  std::size_t starts = 8;
  std::uint64_t seed = 1;
  std::string output;
};

eval::material::MaterialOptions material_options(const EstimateOptions& options) {
  eval::material::MaterialOptions material;
  material.law = eval::damping::damping_law(options.model);
  material.motion = eval::material::parse_heard_motion(options.heard);
  if (!options.contact_time.empty()) {
    material.contact_time = core::parse_quantity(options.contact_time, core::Dimension::time);
    if (!(*material.contact_time >= 0)) {
      throw core::InputError("--contact-time must not be negative");
    }
  }
  material.searches = options.starts;
  material.starts.seed = options.seed;
  return material;
}

/// A quantity that may be left out.
std::optional<double> quantity_of(const std::string& text, core::Dimension dimension) {
  if (text.empty()) return std::nullopt;
  return core::parse_quantity(text, dimension);
}

struct Recording {
  std::vector<double> samples;
  eval::features::FeatureSet set;
};

Recording listen(const EstimateOptions& options) {
  ChannelClip clip = read_channel(options.recording, options.channel);
  Recording recording;
  recording.samples = std::move(clip.samples);
  eval::features::FeatureOptions features;
  if (!options.onset.empty()) {
    features.onset = core::parse_quantity(options.onset, core::Dimension::time);
  }
  features.rt60 = parse_rt60(options.rt60);
  recording.set = eval::features::extract_features(recording.samples, clip.sample_rate, features);
  if (recording.set.features.empty()) {
    throw core::InputError(
        fmt::format("{}: no modes can be heard: {}", options.recording, recording.set.nothing),
        "a material is estimated from a struck object's ringing");
  }
  return recording;
}

void run_estimate(const EstimateOptions& options, Context& context) {
  const eval::material::MaterialOptions wanted = material_options(options);
  const synth::material::Material assumed = eval::material::assumed_material(
      options.object.material, quantity_of(options.poisson_ratio, core::Dimension::none),
      quantity_of(options.density, core::Dimension::density));
  scene::ObjectRequest request;
  mpi::agreed(context.world, [&] { request = object_request(options.object); });
  request.materials = {{"", assumed}};
  const Vec3 at = parse_position(options.at);
  std::optional<Vec3> direction;
  if (!options.direction.empty()) direction = parse_position(options.direction);
  if (direction && !(direction->norm() > 0)) {
    throw core::InputError("--direction has no length");
  }
  Recording recording;
  core::Trace trace;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    const core::ScopedTimer timer(trace.stages["features"]);
    recording = listen(options);
  });
  const scene::SolvedObject object = scene::solve_object(request, context.world, context.cache);
  if (!context.speaks()) return;
  trace.merge(object.trace);
  if (object.materials.size() != 1) {
    throw core::InputError(
        fmt::format("{} has {} regions", options.object.mesh, object.materials.size()),
        "one material is estimated: give an object of one region");
  }
  const solvers::elements::Elastic& elastic = object.materials.front().elastic;
  const double modulus = elastic.youngs_modulus / elastic.density;
  const synth::modal::Strike strike = eval::material::unit_strike(object.modes, at, direction);
  const eval::material::StruckModes modes =
      eval::material::struck_modes(object.modes, strike.point, strike.direction, modulus);
  eval::material::MaterialEstimate estimate;
  {
    const core::ScopedTimer timer(trace.stages["search"]);
    estimate = eval::material::estimate_material(recording.samples, recording.set, modes, wanted);
  }
  if (!options.output.empty()) {
    core::write_wav(options.output,
                    eval::material::resynthesis(recording.samples, recording.set, object.modes,
                                                strike, estimate.candidate, modulus, wanted.motion),
                    core::SampleFormat::float32);
  }
  estimate.remarks.insert(estimate.remarks.begin(), recording.set.remarks.begin(),
                          recording.set.remarks.end());
  std::optional<double> density;
  if (!options.density.empty()) density = elastic.density;
  if (context.json) {
    fmt::print("{}\n", eval::material::to_json(estimate, recording.set, density, trace).dump(2));
  } else {
    eval::material::print_estimate(estimate, recording.set, density, trace);
  }
}

}  // namespace

void add_estimate(Program& program, Context& context) {
  Command& command = program.add(
      "estimate",
      "material of a struck object from one recording, its mesh and where it was struck",
      Needs::solver);
  auto options = std::make_shared<EstimateOptions>();
  command.option("recording", options->recording, "WAV or any file that libsndfile reads")
      .required();
  add_object_options(command, options->object);
  command.option_named("--material")
      .required(false)
      .description(
          "assumed material, whose modes are solved once and rescaled: preset or "
          "youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700; its damping is not "
          "used")
      .show_default("70 GPa, 2500 kg/m^3");
  command.option("--at", options->at, "point struck, x,y,z [m]").required();
  command.option("--direction", options->direction,
                 "way the force points, x,y,z (default: inward along the normal)");
  command.option("--poisson-ratio", options->poisson_ratio,
                 "of the object; it is not estimated (default: the assumed material's)");
  command.option("--density", options->density,
                 "of the object; gives Young's modulus, which cannot be heard without it");
  command
      .option("--model", options->model,
              "rayleigh, caughey, power, hybrid, or a formula of lambda, omega, f and "
              "alpha1, alpha2, ...")
      .show_default();
  command
      .option("--heard", options->heard,
              "motion of the struck point that the recording follows: velocity (strike "
              "without listeners), acceleration (microphones), displacement")
      .show_default();
  command.option("--contact-time", options->contact_time,
                 "duration of the contact; 0: an ideal impulse (default: estimated too)");
  command.option("--channel", options->channel, "of the recording, from 1")
      .range(1, 1000)
      .show_default();
  command.option("--onset", options->onset, "where the strike begins (default: it is found)");
  command.option("--rt60", options->rt60,
                 "reverberation time of the room, or T1,T2,... by octave from 125 Hz on: damping "
                 "that cannot be told from its decay is not used");
  command.option("--starts", options->starts, "local searches, from the best start points")
      .range(1, 1000)
      .show_default();
  command.option("--seed", options->seed, "of everything that is drawn").show_default();
  command.option("-o,--output", options->output,
                 "WAV file of the estimate, as long and as loud as the recording");
  command.footer(
      "Examples:\n"
      "  carillon strike bowl -m glass --at 0.06,0,0.05 -o bowl.wav\n"
      "  carillon estimate bowl.wav bowl --at 0.06,0,0.05 --poisson-ratio 0.2 --density 2600\n"
      "  carillon estimate plate.wav plate.obj --at 5,2,0cm -m ceramic --heard acceleration "
      "--model hybrid -o again.wav");
  command.does([&context, options] { run_estimate(*options, context); });
}

}  // namespace carillon::cli
