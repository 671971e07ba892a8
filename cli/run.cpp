#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "cli/context.hpp"
#include "cli/text.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/storage_error.hpp"
#include "mpi/comm.hpp"
#include "mpi/failure.hpp"
#include "mpi/patience.hpp"

namespace carillon::cli {

bool Context::speaks() const {
  return mpi::rank(world) == 0;
}

namespace {

constexpr AddCommand commands[] = {
    add_build,      add_plan,    add_preview,    add_check,    add_regenerate,   add_modes,
    add_inspect,    add_strike,  add_list,       add_accuracy, add_features,     add_fit,
    add_estimate,   add_compare, add_texture,    add_export,   add_export_faust, add_export_gltf,
    add_realimpact, add_report,  add_completion, add_manual};

/// Waits until every rank has ended its command, without holding a core.
/// @param seconds  after which it gives up
/// @return whether they all came
/// @note Collective.
bool everyone_arrives(MPI_Comm world, double seconds) {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(world, &request);
  return mpi::wait_patiently(request, seconds);
}

/// The lowest rank whose command failed, or as many as there are ranks.
/// @note Collective.
int first_failed(MPI_Comm world, bool failed) {
  const int here = failed ? mpi::rank(world) : mpi::size(world);
  int first = 0;
  MPI_Allreduce(&here, &first, 1, MPI_INT, MPI_MIN, world);
  return first;
}

/// Ends a command that this rank is done with. Rank 0 may have more to do, and may fail at it: it
/// then finds the others here, and need not end them by force.
int succeed(const Context& context) {
  everyone_arrives(context.world, mpi::endless);
  first_failed(context.world, false);
  return context.exit_code;
}

int fail(const Context& context, ExitCode code, const char* message) {
  constexpr double patience_s = 5;
  const auto tell = [&] {
    std::fprintf(stderr, "carillon: rank %d: %s\n", mpi::rank(context.world), message);
  };
  if (context.speaks()) std::fprintf(stderr, "carillon: %s\n", message);
  if (!everyone_arrives(context.world, patience_s)) {
    // The others are in a collective call that this rank will never join: end them all.
    if (!context.speaks()) tell();
    MPI_Abort(context.world, code);
  }
  const int first = first_failed(context.world, true);
  if (first != 0 && first == mpi::rank(context.world)) tell();
  return code;
}

}  // namespace

int run(int argc, char** argv, MPI_Comm world, std::span<const AddCommand> more) {
  // Standard output belongs to results: a warning among them would spoil --json.
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "carillon", std::make_shared<spdlog::sinks::stderr_color_sink_mt>()));

  Context context;
  context.world = world;
  context.command = typed_command(argc, argv);

  CLI::App program{
      "Carillon: datasets of struck objects, from shapes and materials to modes, sounds, voxels "
      "and "
      "pictures.\nRuns with or without mpirun."};
  program.name("carillon");
  program.set_version_flag("--version", "carillon " CARILLON_VERSION);
  program.require_subcommand(1);
  program.fallthrough();
  program.add_flag("--json", context.json, "print one JSON document on standard output");
  program.add_flag("--quiet", context.quiet, "no progress lines");
  context.cache = core::default_cache_folder();
  program
      .add_option("--cache", context.cache,
                  "folder for meshes and modes that can be used again; \"\" for none")
      ->capture_default_str();
  for (const AddCommand add : commands) add(program, context);
  for (const AddCommand add : more) add(program, context);
  program.footer(
      "Exit codes: 0 done, 1 internal error, 2 wrong usage, configuration or input, or a body "
      "that\n"
      "cannot be solved within the limits asked for, 3 finished but some tasks failed "
      "(failures.json)\n"
      "or a pitch target was not met, 130 interrupted (run again to go on), 152 a task did not "
      "heed "
      "its\n"
      "limit of time (run again to go on without it).\n"
      "Guide: docs/guide.md");

  try {
    program.parse(argc, argv);
    return succeed(context);
  } catch (const CLI::ParseError& error) {
    const bool wanted = error.get_exit_code() == 0;  // --help and --version
    if (context.speaks()) program.exit(error);
    return wanted ? exit_done : exit_input;
  } catch (const core::ConfigError& error) {
    return fail(context, exit_input, error.what());
  } catch (const core::InputError& error) {
    return fail(context, exit_input, error.what());
  } catch (const core::StorageError& error) {
    const int code = fail(context, exit_input, error.what());
    // HDF5 cannot close a file that the disk had no room for, and crashes over it in MPI_Finalize.
    std::fflush(nullptr);
    _exit(code);
  } catch (const core::FileError& error) {
    return fail(context, exit_input, error.what());
  } catch (const core::SolverError& error) {
    // A body that cannot be solved, or not within the limits that were asked for.
    return fail(context, exit_input, error.what());
  } catch (const mpi::TaskError& error) {
    return fail(context, error.failure().kind == "Error" ? exit_internal : exit_input,
                error.what());
  } catch (const std::exception& error) {
    return fail(context, exit_internal, error.what());
  }
}

}  // namespace carillon::cli
