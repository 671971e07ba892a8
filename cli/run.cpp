#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/learning_commands.hpp"
#include "core/error.hpp"
#include "core/failure.hpp"
#include "core/files.hpp"
#include "core/log.hpp"
#include "core/revision.hpp"
#include "core/storage_error.hpp"
#include "core/text.hpp"
#include "dataset/run/dataset.hpp"
#include "mpi/backoff.hpp"
#include "mpi/comm.hpp"
#include "mpi/launcher.hpp"
#include "solvers/libraries/environment.hpp"

namespace carillon::cli {

namespace {

constexpr AddCommand commands[] = {
    add_build,        add_status,      add_plan,       add_preview, add_check,   add_regenerate,
    add_modes,        add_inspect,     add_strike,     add_play,    add_list,    add_accuracy,
    add_features,     add_fit,         add_estimate,   add_compare, add_texture, add_export,
    add_export_faust, add_export_gltf, add_realimpact, add_score,   add_report,  add_schema,
    add_completion,   add_manual};

/// Waits until every rank has ended its command, without holding a core.
/// @param seconds  after which it gives up
/// @return whether they all came
/// @note Collective.
bool everyone_arrives(MPI_Comm world, double seconds) {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(world, &request);
  return mpi::wait_idly(request, seconds);
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
  if (context.world == MPI_COMM_NULL) return context.exit_code;
  everyone_arrives(context.world, mpi::endless);
  first_failed(context.world, false);
  return context.exit_code;
}

/// Says what went wrong, to people and, with --json, to programs.
/// @param who  begins what people read; "" or "rank 1: "
void say(const core::Failure& failure, const std::string& who, bool json) {
  const std::string hint = failure.hint.empty() ? "" : "\n  hint: " + failure.hint;
  std::fprintf(stderr, "carillon: %s%s%s\n", who.c_str(), failure.message.c_str(), hint.c_str());
  core::log_to_file(who + failure.message + hint);
  if (!json) return;
  // Throws nothing: another error is on its way.
  std::printf("{\"error\": %s}\n", core::to_record(failure).c_str());
  std::fflush(stdout);
}

/// Says what went wrong, and ends the command on every rank.
/// @return the exit code
int fail(const Context& context, const std::exception_ptr& error) {
  constexpr double timeout_s = 5;
  core::Failure failure = core::describe(error);
  if (context.chosen != nullptr) {
    failure.message = context.chosen->in_options(failure.message);
    failure.hint = context.chosen->in_options(failure.hint);
  }
  const mpi::ExitCode code = mpi::exit_code_of(failure);
  const auto tell = [&] {
    say(failure, fmt::format("rank {}: ", mpi::rank(context.world)), context.json);
  };
  if (context.speaks()) say(failure, "", context.json);
  if (context.world == MPI_COMM_NULL) return code;
  if (!everyone_arrives(context.world, timeout_s)) {
    // The others are in a collective call that this rank will never join: end them all.
    if (!context.speaks()) tell();
    MPI_Abort(context.world, code);
  }
  const int first = first_failed(context.world, true);
  if (first != 0 && first == mpi::rank(context.world)) tell();
  return code;
}

/// Libraries that run for the program's life, and end in the other order.
struct Started {
  std::optional<mpi::Environment> mpi{};
  std::optional<solvers::libraries::SolverEnvironment> solver{};
};

/// @note Collective where a launcher started the program.
void start(Started& started, Needs needs, Context& context, int argc, char** argv) {
  // Whoever starts ranks means them to know each other: one of them speaks and writes.
  if (needs == Needs::nothing && !mpi::launcher_rank()) return;
  {
    const mpi::AloneSettings settings;
    started.mpi.emplace(argc, argv);
  }
  context.world = MPI_COMM_WORLD;
  if (needs == Needs::solver) started.solver.emplace();
}

std::string version_text() {
  std::string text = std::string("carillon ") + core::revision();
  const nlohmann::json versions = dataset::run::program_versions();
  for (const auto& [library, version] : versions.items()) {
    if (library != "carillon") text += "\n" + library + " " + version.get<std::string>();
  }
  return text;
}

void describe(Program& program, Context& context, const LearningCommands& learning) {
  Command& common = program.common();
  common.flag("--json", context.json, "print one JSON document on standard output");
  common.flag("--quiet", context.quiet, "no progress lines");
  common.flag("--verbose", context.verbose, "a line for each task, too");
  common.option("--log", context.log,
                "file that also gets, with dates, what is said; what is in it stays");
  common.option("--on-finish", context.finish_command,
                "command of the shell that runs when this one has ended, also where it was killed: "
                "$CARILLON_EXIT_CODE and a build's $CARILLON_OUTPUT tell of it");
  context.cache = core::default_cache_folder();
  common
      .option("--cache", context.cache,
              "folder for meshes and modes that can be used again; \"\" for none")
      .show_default();
  for (const AddCommand add : commands) add(program, context);
  add_learning_commands(program, context, learning);
  common.footer(
      "Exit codes: 0 done, 1 internal error, 2 wrong usage, configuration or input, or an object "
      "that\n"
      "cannot be solved within the limits asked for, 3 finished but some tasks failed "
      "(failures.json)\n"
      "or a pitch target was not met, 130 interrupted (run again to go on), 152 a task did not "
      "heed "
      "its\n"
      "limit of time (run again to go on without it). With --json a failure is also on standard\n"
      "output, as {\"error\": {\"kind\", \"message\", \"hint\"}}.\n"
      "Guide: docs/guide.md");
}

/// @return the exit code
int tell(const Reply& reply, Context& context, int argc, char** argv) {
  Started started;
  // A launcher ends every rank when one has failed. MPI keeps them until rank 0 has spoken.
  if (reply.refused) start(started, Needs::nothing, context, argc, argv);
  if (context.speaks()) {
    if (reply.refused) {
      // The command line may have been given up before the option was read.
      const bool json = std::any_of(argv + 1, argv + argc, [](const char* word) {
        return std::string_view(word) == "--json";
      });
      say({"InputError", reply.text, reply.hint}, "", json);
    } else {
      fmt::print("{}", reply.text);
    }
  }
  return reply.refused ? mpi::exit_input : mpi::exit_done;
}

/// Standard streams that whoever started the program has closed are held by what cannot be written
/// to, so that no file that is opened takes their numbers and gets what is meant for them.
void hold_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    // The lowest number that is free is taken.
    if (::fcntl(stream, F_GETFD) < 0) static_cast<void>(::open("/dev/null", O_RDONLY));
  }
}

/// What was asked to be said while the command works.
/// @throws InputError, FileError
void start_log(const Context& context) {
  if (context.quiet && context.verbose) {
    throw core::InputError("--quiet and --verbose exclude each other", "leave one of them out");
  }
  core::start_log(context.quiet || context.json ? core::Detail::warnings
                  : context.verbose             ? core::Detail::tasks
                                                : core::Detail::progress,
                  context.log);
  if (context.speaks()) core::log_to_file(context.command);
}

/// Gives standard output what is still meant for it.
/// @return the system's number of what is wrong with it; 0: nothing
int finish_output() {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return 0;
  return errno != 0 ? errno : EIO;
}

/// What could not be written to standard output is forgotten: libraries that end later would
/// complain of it again.
void drop_output() {
  if (std::freopen("/dev/null", "w", stdout) == nullptr) std::clearerr(stdout);
}

/// Ends a command whose results nobody can read.
/// @return the exit code
int fail_to_speak(const Context& context, int error) {
  drop_output();
  // A reader that has gone, as in `carillon ... | head`, has read enough.
  if (error == EPIPE) {
    if (context.world != MPI_COMM_NULL) succeed(context);
    return 128 + SIGPIPE;
  }
  return fail(context, std::make_exception_ptr(
                           core::FileError(fmt::format("standard output: cannot be written: {}",
                                                       std::generic_category().message(error)),
                                           "files that were made are whole")));
}

}  // namespace

void set_libraries_up() {
  setenv("HDF5_USE_FILE_LOCKING", "FALSE", 0);
  setenv("LP_NUM_THREADS", "0", 0);
  setenv("MESA_SHADER_CACHE_DISABLE", "true", 0);
  setenv("LIBGL_ALWAYS_SOFTWARE", "true", 0);  // the same bytes, whatever hardware EGL finds
}

namespace {

/// @return the exit code
int run_command_line(Program& program, Context& context, int argc, char** argv) {
  Started started;
  try {
    if (const auto reply = program.parse(argc, argv)) {
      const int code = tell(*reply, context, argc, argv);
      const int error = finish_output();
      return error == 0 ? code : fail_to_speak(context, error);
    }
    const Command& command = program.chosen();
    context.chosen = &command;
    command.begin();
    if (context.speaks()) context.on_finish.watch(context.finish_command);
    start(started, command.needs(), context, argc, argv);
    start_log(context);
    command.run();
    if (const int error = finish_output(); error != 0) return fail_to_speak(context, error);
    return succeed(context);
  } catch (const core::StorageError&) {
    const int code = fail(context, std::current_exception());
    // HDF5 cannot close a file that the disk had no room for, and crashes over it in MPI_Finalize.
    std::fflush(nullptr);
    context.on_finish.finish(code);
    _exit(code);
  } catch (const std::system_error& error) {
    // fmt's, of standard output.
    if (std::ferror(stdout) != 0) return fail_to_speak(context, error.code().value());
    return fail(context, std::current_exception());
  } catch (const std::exception&) {
    return fail(context, std::current_exception());
  }
}

}  // namespace

int run(int argc, char** argv, const LearningCommands& learning) {
  hold_standard_streams();
  core::start_log(core::Detail::progress);

  Context context;
  context.arguments = argv;
  context.command = core::typed_command(argc, argv);
  Program program("carillon",
                  "Carillon: datasets of struck objects, from shapes and materials to modes, "
                  "sounds, voxels and pictures.\nRuns with or without mpirun.",
                  version_text);
  describe(program, context, learning);
  const int code = run_command_line(program, context, argc, argv);
  context.on_finish.finish(code);
  return code;
}

}  // namespace carillon::cli
