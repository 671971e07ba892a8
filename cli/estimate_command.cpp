#include <fmt/format.h>

#include <optional>

#include "cli/command_line.hpp"
#include "cli/object_options.hpp"
#include "cli/option_values.hpp"
#include "cli/recording.hpp"
#include "core/audio.hpp"
#include "core/files.hpp"
#include "eval/material/estimate_recording.hpp"
#include "eval/material/estimate_report.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

namespace {

struct EstimateOptions {
  ObjectOptions object;
  eval::material::EstimateArguments estimate;
  std::string recording;
  int channel = 1;
  std::string at, direction;
  std::string output;
};

void run_estimate(const EstimateOptions& options, Context& context) {
  const eval::material::MaterialOptions wanted = eval::material::material_options(options.estimate);
  const synth::material::Material assumed =
      eval::material::assumed_material(options.object.material, options.estimate);
  scene::ObjectRequest request;
  mpi::agreed(context.world, [&] { request = object_request(options.object); });
  request.materials = {{"", assumed}};
  std::optional<Vec3> direction;
  if (!options.direction.empty()) direction = parse_position(options.direction, "--direction");
  const eval::material::StruckPlace place =
      eval::material::struck_place(parse_position(options.at, "--at"), direction);
  request.struck = {place.at};
  require_output_file(context, options.output);
  eval::material::HeardRecording recording;
  core::Trace trace;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    const core::ScopedTimer timer(trace.stages["features"]);
    ChannelClip clip = read_channel(options.recording, options.channel);
    recording = eval::material::listen(std::move(clip.samples), clip.sample_rate, options.estimate,
                                       options.recording);
  });
  const scene::SolvedObject object = scene::solve_object(request, context.world, context.cache);
  if (!context.speaks()) return;
  trace.merge(object.trace);
  const eval::material::RecordedMaterial found = eval::material::estimate_recording(
      recording, object.modes, object.materials, place, wanted, options.object.mesh, trace);
  if (!options.output.empty()) {
    core::write_durably(options.output, [&](const std::filesystem::path& path) {
      core::write_wav(path, found.resynthesis, core::SampleFormat::float32);
    });
  }
  const auto density = eval::material::known_density(options.estimate);
  if (context.json) {
    fmt::print("{}\n",
               eval::material::to_json(found.estimate, recording.set, density, trace).dump(2));
  } else {
    eval::material::print_estimate(found.estimate, recording.set, density, trace);
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
      .description(
          "assumed material, whose modes are solved once and rescaled: preset or "
          "youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700; its damping is not "
          "used")
      .show_default("70 GPa, 2500 kg/m^3");
  command.option("--at", options->at, "point struck, x,y,z [m]").required();
  command.option("--direction", options->direction,
                 "way the force points, x,y,z (default: inward along the normal)");
  command.option("--poisson-ratio", options->estimate.poisson_ratio,
                 "of the object; it is not estimated (default: the assumed material's)");
  command.option("--density", options->estimate.density,
                 "of the object; gives Young's modulus, which cannot be heard without it");
  command
      .option("--model", options->estimate.model,
              "rayleigh, caughey, power, hybrid, or a formula of lambda, omega, f and "
              "alpha1, alpha2, ...")
      .show_default();
  command
      .option("--heard", options->estimate.heard,
              "motion of the struck point that the recording follows: velocity (strike "
              "without listeners), acceleration (microphones), displacement")
      .show_default();
  command.option("--contact-time", options->estimate.contact_time,
                 "duration of the contact; 0: an ideal impulse (default: estimated too)");
  command.option("--channel", options->channel, "of the recording, from 1")
      .range(1, 1000)
      .show_default();
  command.option("--onset", options->estimate.onset,
                 "where the strike begins (default: it is found)");
  command.option("--rt60", options->estimate.rt60,
                 "reverberation time of the room, or T1,T2,... by octave from 125 Hz on: damping "
                 "that cannot be told from its decay is not used");
  command.option("--starts", options->estimate.starts, "local searches, from the best start points")
      .range(std::size_t{1}, eval::material::EstimateArguments::max_starts)
      .show_default();
  command.option("--seed", options->estimate.seed, "of everything that is drawn").show_default();
  command.option("-o,--output", options->output,
                 "WAV file of the estimate, as long and as loud as the recording");
  command.footer(
      "Examples:\n"
      "  carillon strike bowl -m glass --at 0.08,0,0.05 -o bowl.wav\n"
      "  carillon estimate bowl.wav bowl --at 0.08,0,0.05 --poisson-ratio 0.2 --density 2600\n"
      "  carillon estimate plate.wav plate.obj --at 5,2,0cm -m ceramic --heard acceleration "
      "--model hybrid -o again.wav");
  command.does([&context, options] { run_estimate(*options, context); });
}

}  // namespace carillon::cli
