#include "eval/accuracy/accuracy.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <thread>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/progress.hpp"
#include "dataset/run/dataset.hpp"
#include "eval/accuracy/detail/modes_line.hpp"
#include "eval/accuracy/detail/stand_in.hpp"
#include "mpi/comm.hpp"
#include "mpi/made_by.hpp"

namespace carillon::eval::accuracy {

using nlohmann::json;

namespace {

/// Load of the machine over the last minute: what else ran spoils wall times.
double load_average() {
  double load = 0;
  return getloadavg(&load, 1) == 1 ? load : 0;
}

/// An object whose file is missing gets its stand-in, or is passed over.
/// @return whether there is an object to measure
bool find_object(StudiedObject& object, Findings& findings, const std::filesystem::path& output,
                 const std::string& cache, MPI_Comm comm) {
  const std::string& path = object.request.file.path;
  if (path.empty() || std::filesystem::exists(path)) return true;
  if (object.stand_in) {
    findings.note =
        fmt::format("{} is missing: a noisy {} in its place", path, object.stand_in->shape.family);
    const auto file = output / (object.name + "-stand-in.off");
    mpi::agreed(comm, [&] {
      if (mpi::rank(comm) == 0) write_stand_in(*object.stand_in, file, cache);
    });
    object.request.file = {};
    object.request.file.path = file.string();
    return true;
  }
  // It may have gone since the configuration was read.
  if (!object.optional) throw core::FileError(fmt::format("{}: no such file", path));
  findings.failure = fmt::format("passed over, {} is missing", path);
  findings.passed_over = true;
  return false;
}

/// Fills in the findings as they come: what stands when something throws stays.
void climb(const AccuracyConfig& config, const StudiedObject& object, LevelRunner& runner,
           Findings& findings, const std::function<void(const std::string&)>& tell) {
  tell("reference of " + object.name);
  findings.reference = runner.reference();
  for (const int order : object.orders)
    for (const double size : object.size_factors) {
      tell(fmt::format("{}, order {}, size x {:.3g}", object.name, order, size));
      runner.at_factor(order, size, config.tolerances.front());
    }
  const int usual_order = solvers::mesh::MeshOptions().order;
  for (std::size_t i = 1; i < config.tolerances.size(); ++i) {
    tell(fmt::format("{}, tolerance {:.0e}", object.name, config.tolerances[i]));
    runner.at_factor(usual_order, 1, config.tolerances[i]);
  }
  for (const double cents : config.pitch_targets) {
    tell(fmt::format("{}, {:.3g} cents", object.name, cents));
    Choice& choice = findings.choices.emplace_back();
    choice.cents = cents;
    choice.command = modes_line(object, runner.target_band(), config.max_elements, cents);
    try {
      choice.report = runner.choose(cents);
      for (const auto& step : choice.report.steps) choice.steps.push_back(runner.level_of(step));
    } catch (const core::Error& error) {
      choice.failure = error.message();
    }
  }
}

Findings measure_object(const AccuracyConfig& config, StudiedObject object,
                        const std::filesystem::path& output, const std::string& cache,
                        MPI_Comm comm, const std::function<void(const std::string&)>& tell) {
  Findings findings;
  findings.name = object.name;
  LevelRunner runner(config, object, cache, comm);
  try {
    if (find_object(object, findings, output, cache, comm)) {
      climb(config, object, runner, findings, tell);
    }
  } catch (const core::Error& error) {
    findings.failure = error.message();
  }
  if (findings.reference.frequencies.empty()) return findings;
  for (const auto& level : runner.levels()) {
    findings.levels.push_back(compare(config, *level, findings.reference));
  }
  return findings;
}

/// What a part found, or why it found nothing.
template <class Climb>
auto found_or_failure(const Climb& climb) -> decltype(climb()) {
  try {
    return climb();
  } catch (const core::Error& error) {
    return {.failure = error.message()};
  }
}

StudyFindings measure(const AccuracyConfig& config, const std::filesystem::path& output,
                      const AccuracyOptions& options, MPI_Comm world, MPI_Comm comm) {
  const double start = core::monotonic_seconds();
  core::Progress progress("accuracy", static_cast<double>(config.objects.size()),
                          mpi::rank(world) != 0);
  StudyFindings findings;
  json& document = findings.document;
  document = {{"name", config.name},
              {"carillon", dataset::run::program_versions()},
              {"made", mpi::made_by(options.command, world)},
              {"machine",
               {{"processor", mpi::processor_name()},
                {"cores", std::thread::hardware_concurrency()},
                {"ranks", mpi::size(comm)},
                {"load_before", load_average()}}},
              {"clock", config.cpu_time ? "processor" : "wall"},
              {"modes", config.band.max_modes},
              {"tolerance", config.tolerances.front()},
              {"finished", false},
              {"configuration", config.resolved},
              {"objects", json::array()}};
  const auto keep = [&] {
    document["seconds"] = core::monotonic_seconds() - start;
    mpi::agreed(comm, [&] {
      if (mpi::rank(comm) == 0) {
        core::write_text_durably(output / "accuracy.json", document.dump(1) + "\n");
      }
    });
  };
  if (config.sound) {
    findings.sound =
        found_or_failure([&] { return measure_sounds(*config.sound, comm, options.cache); });
    document["sound"] = to_json(*findings.sound);
    keep();
  }
  if (config.features) {
    findings.features = found_or_failure([&] { return measure_features(*config.features); });
    document["features"] = to_json(*findings.features);
    keep();
  }
  for (std::size_t i = 0; i < config.objects.size(); ++i) {
    const auto tell = [&](const std::string& note) {
      progress.update(static_cast<double>(i), note);
    };
    findings.objects.push_back(
        measure_object(config, config.objects[i], output, options.cache, comm, tell));
    document["objects"].push_back(to_json(findings.objects.back()));
    document["finished"] = i + 1 == config.objects.size();
    keep();
  }
  if (config.objects.empty()) {
    document["finished"] = true;
    keep();
  }
  progress.finish("");
  return findings;
}

}  // namespace

bool has_failed(const StudyFindings& findings) {
  return (findings.sound && !findings.sound->failure.empty()) ||
         (findings.features && !findings.features->failure.empty()) ||
         std::any_of(findings.objects.begin(), findings.objects.end(),
                     [](const Findings& object) { return has_failed(object); });
}

void print(const StudyFindings& findings) {
  for (const Findings& object : findings.objects) print(object);
  if (findings.sound) print(*findings.sound);
  if (findings.features) print(*findings.features);
}

StudyFindings measure_accuracy(const AccuracyConfig& config, const std::filesystem::path& output,
                               const AccuracyOptions& options, MPI_Comm world) {
  if (config.all_ranks) return measure(config, output, options, world, world);
  StudyFindings findings;
  mpi::agreed(world, [&] {
    if (mpi::rank(world) == 0) findings = measure(config, output, options, world, MPI_COMM_SELF);
  });
  return findings;
}

}  // namespace carillon::eval::accuracy
