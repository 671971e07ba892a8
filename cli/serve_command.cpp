#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "cli/command_line.hpp"
#include "cli/learn_program.hpp"
#include "cli/learning_commands.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/made_by.hpp"
#include "report/service/service.hpp"

namespace carillon::cli {

namespace {

struct ServeOptions {
  report::service::ServiceOptions service;
  std::string token_file, models, device;
  double body_mb = 64;
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

void serve(const ServeOptions& options, const Context& context, IdentifierMaker identifier) {
  if (mpi::size(context.world) > 1) {
    throw core::InputError("serve is one process, and mpirun started several",
                           "start it without mpirun");
  }
  report::service::ServiceOptions own = options.service;
  own.made = mpi::made_by(context.command, context.world);
  own.http.body = static_cast<std::size_t>(options.body_mb * 1e6);
  if (!options.token_file.empty()) own.token = read_token(options.token_file);
  if (!options.models.empty()) {
    if (identifier == nullptr) {
      throw core::InputError("--models needs carillon-learn, which is not installed",
                             "build with libtorch (-DCARILLON_LEARN=ON)");
    }
    own.identify = identifier(options.models, options.device);
  }
  const mpi::InterruptGuard guard;
  report::service::Service service(std::move(own));
  fmt::print("http://{}:{}/\n", options.service.host, service.port());
  std::fflush(stdout);
  // A signal asks it to stop; what is under way is finished.
  std::atomic<bool> ended = false;
  std::thread watcher([&] {
    while (!ended && !mpi::interrupt_requested()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    service.stop();
  });
  service.run();
  ended = true;
  watcher.join();
}

}  // namespace

void add_serve(Program& program, Context& context, IdentifierMaker identifier) {
  Command& command =
      program.add("serve", "the report's page, and answers for sounds, by HTTP", Needs::ranks);
  auto options = std::make_shared<ServeOptions>();
  report::service::ServiceOptions& service = options->service;
  command
      .option("folders", service.folders,
              "folders that build, accuracy or evaluate made, or that hold such")
      .required();
  command
      .option("-m,--models", options->models,
              "folder below which trained networks lie, for /v1/identify")
      .show_default("none");
  add_device(command, options->device);
  command.option("--host", service.host, "address to listen at").show_default();
  command.option("--port", service.port, "0: any that is free").range(0, 65535).show_default();
  command.option("--token", options->token_file,
                 "file whose first line requests must have; asked for beyond this machine");
  command
      .option("--waiting", service.waiting, "requests that wait for a computation; others get 503")
      .range(std::size_t{0}, std::size_t{100000})
      .show_default();
  command.option("--longest-clip", service.longest_clip, "of a sound [s]")
      .range(0.01, 3600.0)
      .show_default();
  command.option("--max-body", options->body_mb, "of a request [MB]")
      .range(0.001, 4000.0)
      .show_default();
  command.footer(
      "Examples:\n"
      "  carillon serve carillon-smoke\n"
      "  carillon serve nightly --models carillon-learning-smoke --port 8080\n"
      "  curl --data-binary @clip.wav http://127.0.0.1:8750/v1/features\n"
      "docs/service.md");
  if (identifier == nullptr) {
    // The program with libtorch serves networks, too.
    command.begins_with([&context, options] {
      if (!options->models.empty()) become_learner(context.arguments);
    });
  }
  command.does([&context, options, identifier] { serve(*options, context, identifier); });
}

}  // namespace carillon::cli
