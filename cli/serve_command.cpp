#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>

#include "cli/command_line.hpp"
#include "cli/learning_commands.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/revision.hpp"
#include "core/storage_error.hpp"
#include "core/text.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"
#include "report/service/service.hpp"

namespace carillon::cli {

namespace {

struct ServeOptions {
  report::service::ServiceOptions service;
  std::string token_file, models, device, launch = "mpirun";
  double body_mb = 64, longest_clip = 60;
};

/// The first line of a file.
std::string read_token(const std::string& path) {
  const std::string text = core::read_file(path);
  std::string token(core::trimmed(text.substr(0, text.find('\n'))));
  constexpr std::size_t shortest = 16;
  if (token.size() < shortest) {
    throw core::InputError(
        fmt::format("--token {}: its first line has {} characters", path, token.size()),
        fmt::format("at least {}, as of `openssl rand -hex 32`", shortest));
  }
  return token;
}

std::filesystem::path own_program() {
  std::error_code unknown;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  if (unknown) throw core::StorageError("/proc/self/exe cannot be read", "it needs /proc");
  return program;
}

/// `carillon answer` with what it takes of the options.
report::service::WorkerOptions workers_of(const ServeOptions& options, const Context& context) {
  report::service::WorkerOptions workers = options.service.workers;
  workers.program = own_program();
  workers.arguments = {"--quiet", "--cache", context.cache, "answer"};
  const auto add = [&](const std::string& word, const std::string& value) {
    if (value.empty()) return;
    workers.arguments.push_back(word);
    workers.arguments.push_back(value);
  };
  add("--models", options.models);
  add("--device", options.device);
  add("--longest-clip", fmt::format("{}", options.longest_clip));
  workers.arguments.emplace_back("--");
  for (const std::string& folder : options.service.folders) workers.arguments.push_back(folder);
  if (!options.service.jobs.empty()) workers.arguments.push_back(options.service.jobs);
  return workers;
}

void serve(const ServeOptions& options, const Context& context) {
  if (context.world != MPI_COMM_NULL && mpi::size(context.world) > 1) {
    throw core::InputError("serve is one process, and mpirun started several",
                           "start it without mpirun");
  }
  report::service::ServiceOptions own = options.service;
  if (own.folders.empty() && own.jobs.empty()) {
    throw core::InputError("there is nothing to serve",
                           "name folders that build, accuracy or evaluate made, or --jobs FOLDER");
  }
  own.made = {{"command", context.command}, {"carillon", core::revision()}};
  // Whoever waits for a worker or listens holds one; health and cancelling come through.
  own.http.connections =
      std::min<std::size_t>(512, own.workers.waiting + own.workers.count + own.http.listeners + 16);
  own.http.body = static_cast<std::size_t>(options.body_mb * 1e6);
  own.launcher = options.launch == "slurm" ? report::service::Launcher::slurm
                                           : report::service::Launcher::mpirun;
  own.cache = context.cache;
  own.workers = workers_of(options, context);
  if (!options.token_file.empty()) own.token = read_token(options.token_file);
  const mpi::InterruptGuard guard;
  report::service::Service service(std::move(own));
  fmt::print("http://{}:{}/\n", options.service.host, service.port());
  std::fflush(stdout);
  // A signal asks it to stop; what is under way is finished.
  std::atomic<bool> ended = false;
  std::thread watcher([&] {
    // Again and again: what is asked before it listens would be lost.
    while (!ended) {
      if (mpi::interrupt_requested()) service.stop();
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  });
  service.run();
  ended = true;
  watcher.join();
}

}  // namespace

void add_serve(Program& program, Context& context) {
  Command& command = program.add(
      "serve", "the report's page, answers for sounds, and jobs, by HTTP", Needs::nothing);
  auto options = std::make_shared<ServeOptions>();
  report::service::ServiceOptions& service = options->service;
  const auto cores = std::max<std::size_t>(1, std::thread::hardware_concurrency());
  service.workers.count = cores;
  service.ranks = static_cast<int>(cores);
  command.option("folders", service.folders,
                 "folders that build, accuracy or evaluate made, or that hold such");
  command
      .option("-m,--models", options->models,
              "folder below which trained networks lie, for /v1/identify")
      .show_default("none");
  add_device(command, options->device);
  command.option("--host", service.host, "address to listen at").show_default();
  command.option("--port", service.port, "0: any that is free").range(0, 65535).show_default();
  command.option("--token", options->token_file,
                 "file whose first line requests must have; asked for beyond this machine");
  command.option("--workers", service.workers.count, "processes that compute answers")
      .range(std::size_t{1}, std::size_t{1000})
      .show_default("one for each core");
  command
      .option("--waiting", service.workers.waiting,
              "requests that wait for a worker; others get 503")
      .range(std::size_t{0}, std::size_t{100000})
      .show_default();
  command.option("--time-limit", service.workers.seconds, "for an answer [s]")
      .range(0.1, 86400.0)
      .show_default();
  command.option("--longest-clip", options->longest_clip, "of a sound [s]")
      .range(0.01, 3600.0)
      .show_default();
  command.option("--max-body", options->body_mb, "of a request [MB]")
      .range(0.001, 4000.0)
      .show_default();
  command
      .option("--jobs", service.jobs,
              "folder of the queue of builds, trainings, evaluations and scores; without it none "
              "are taken")
      .show_default("none");
  command.option("--ranks", service.ranks, "of a job, at the most")
      .range(1, 100000)
      .show_default("one for each core");
  command.option("--launch", options->launch, "mpirun here, or slurm (scripts/slurm/job.sbatch)")
      .one_of({"mpirun", "slurm"})
      .show_default();
  command.option("--max-jobs", service.max_jobs, "that wait or run; others get 400")
      .range(std::size_t{1}, std::size_t{100000})
      .show_default();
  command.option(
      "--sealed", service.seals,
      "what `carillon export --hide test` kept: answers by the export's names are scored");
  command.footer(
      "Examples:\n"
      "  carillon serve carillon-smoke\n"
      "  carillon serve nightly --models carillon-learning-smoke --port 8080\n"
      "  carillon serve carillon-smoke --jobs queue --ranks 2\n"
      "  curl --data-binary @clip.wav http://127.0.0.1:8750/v1/features\n"
      "  curl --data-binary @configs/smoke.yaml \"http://127.0.0.1:8750/v1/jobs?command=build\"\n"
      "docs/service.md");
  command.does([&context, options] { serve(*options, context); });
}

}  // namespace carillon::cli
