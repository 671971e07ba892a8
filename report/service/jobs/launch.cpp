#include "report/service/jobs/launch.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

#include "core/child_process.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/near_program.hpp"
#include "core/storage_error.hpp"
#include "core/text.hpp"

namespace carillon::report::service {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* exit_name = "exit";

/// Runs the words after $0, the job's folder, there. Whoever asks it to stop asks its command, too:
/// its own trap keeps it alive until that has ended, so that the exit code is noted.
constexpr const char* run_noted = R"(cd "$0" || exit 127
trap : TERM
"$@" >result.json 2>>errors.txt </dev/null &
while wait $!; code=$?; kill -0 $! 2>/dev/null; do :; done
echo $code >exit.part && mv exit.part exit
)";

/// Of a process of which nothing can be learnt just now.
constexpr std::int64_t unknown = -1;

/// When a process began, in the system's ticks since it started, as numbers are given again; 0:
/// there is none, or it has ended.
std::int64_t began(pid_t id) {
  const std::string path = fmt::format("/proc/{}/stat", id);
  std::ifstream file(path);
  std::error_code unreadable;
  if (!file) return fs::exists(path, unreadable) || unreadable ? unknown : 0;
  std::string text{std::istreambuf_iterator<char>(file), {}};
  text.erase(0, text.rfind(')') + 1);
  // Fields 3 to 22 of proc(5), after the program's name.
  std::istringstream rest(text);
  std::string state, skipped;
  rest >> state;
  for (int field = 4; field < 22; ++field) rest >> skipped;
  std::int64_t ticks = 0;
  rest >> ticks;
  return state.empty() || state == "Z" ? 0 : ticks;
}

std::optional<int> noted_exit(const fs::path& folder) {
  std::error_code missing;
  if (!fs::exists(folder / exit_name, missing)) return std::nullopt;
  const auto code =
      core::number_in<std::int64_t>(core::trimmed(core::read_file(folder / exit_name)));
  if (!code) return std::nullopt;
  return static_cast<int>(*code);
}

/// A program of Slurm's.
core::ChildExit ask_slurm(const std::string& program, std::vector<std::string> words) {
  words.insert(words.begin(), program);
  constexpr double seconds = 60;
  return core::run_child("/usr/bin/env", words, seconds);
}

fs::path slurm_scripts() {
  const fs::path found = core::find_near_program(
      {"../share/carillon/scripts/slurm/job.sbatch", "../scripts/slurm/job.sbatch"});
  if (found.empty()) {
    throw core::StorageError("scripts/slurm was not found", "it lies beside the program");
  }
  return found.parent_path();
}

json start_slurm(const fs::path& folder, const Job& job, const fs::path& program) {
  const fs::path scripts = slurm_scripts();
  std::vector<std::string> words = {
      "--parsable",
      fmt::format("--job-name=carillon-{}", job.id),
      fmt::format("--ntasks={}", job.ranks),
      "--chdir=" + folder.string(),
      "--output=" + (folder / job_errors).string(),
      fmt::format("--export=ALL,CARILLON={},CARILLON_SLURM={}", program.string(), scripts.string()),
      (scripts / "job.sbatch").string(),
      job.command};
  words.insert(words.end(), job.arguments.begin(), job.arguments.end());
  const core::ChildExit exit = ask_slurm("sbatch", words);
  const std::string id(core::trimmed(exit.output.substr(0, exit.output.find(';'))));
  const std::optional<std::int64_t> number = core::number_in<std::int64_t>(id);
  if (exit.code != 0 || exit.signal != 0 || !number) {
    throw core::StorageError(fmt::format("sbatch: {}", core::trimmed(exit.output)),
                             "carillon serve --launch mpirun starts jobs by itself");
  }
  return {{"slurm", *number}};
}

JobProcess find_slurm(const fs::path& folder, std::int64_t id) {
  const core::ChildExit exit = ask_slurm(
      "squeue", {"--noheader", "--states=all", "--format=%T", fmt::format("--jobs={}", id)});
  const std::string state(core::trimmed(exit.output));
  if (exit.code != 0 && state.find("Invalid job id") == std::string::npos) {
    return {};  // its controller rests
  }
  for (const char* waiting : {"PENDING", "CONFIGURING", "REQUEUED", "REQUEUE_HOLD", "PREEMPTED",
                              "NODE_FAIL", "SUSPENDED"}) {
    if (state == waiting) return {true, true, {}};
  }
  for (const char* running : {"RUNNING", "COMPLETING", "STOPPED", "SIGNALING"}) {
    if (state == running) return {};
  }
  return {false, false, noted_exit(folder)};
}

}  // namespace

json start_process(const fs::path& folder, const Job& job, Launcher launcher,
                   const fs::path& program) {
  fs::remove(folder / exit_name);
  if (launcher == Launcher::slurm && job.command != "score")
    return start_slurm(folder, job, program);
  std::vector<std::string> words = {"-c", run_noted, folder.string()};
  if (job.ranks > 1) {
    for (const std::string& word :
         {std::string("mpirun"), std::string("-n"), fmt::format("{}", job.ranks)}) {
      words.push_back(word);
    }
  }
  for (const std::string& word : {program.string(), std::string("--json"), job.command}) {
    words.push_back(word);
  }
  words.insert(words.end(), job.arguments.begin(), job.arguments.end());
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nothing < 0) throw core::StorageError("/dev/null cannot be opened");
  pid_t id = 0;
  try {
    id = core::start_child("/bin/sh", words, {nothing, nothing, nothing}, /*heeds_signals=*/true);
  } catch (const core::Error&) {
    ::close(nothing);
    throw;
  }
  ::close(nothing);
  return {{"pid", id}, {"began", began(id)}};
}

JobProcess find_process(const fs::path& folder, const json& process) {
  if (process.contains("slurm")) return find_slurm(folder, process.at("slurm"));
  const pid_t id = process.at("pid");
  waitpid(id, nullptr, WNOHANG);  // a child of this service's
  const std::int64_t since = began(id);
  if (since == unknown) return {};
  if (since != 0 && since == process.at("began").get<std::int64_t>()) return {};
  return {false, false, noted_exit(folder)};
}

void stop_process(const json& process, bool by_force) {
  if (process.contains("slurm")) {
    ask_slurm("scancel", {fmt::format("{}", process.at("slurm").get<std::int64_t>())});
    return;
  }
  const pid_t id = process.at("pid");
  const std::int64_t since = began(id);
  if (since != 0 && since == process.at("began").get<std::int64_t>()) {
    kill(-id, by_force ? SIGKILL : SIGTERM);
  }
}

}  // namespace carillon::report::service
