#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace carillon::report::service {

enum class JobState { queued, running, done, failed, cancelled };

/// A command that is run for a client, in a folder of its own.
struct Job {
  int id = 0;
  std::string command;                 ///< build, train, evaluate, score
  std::vector<std::string> arguments;  ///< after it; paths are meant from the job's folder
  int ranks = 1;
  JobState state = JobState::queued;
  std::string created, started, ended;  ///< for people: clocks jump
  int exit_code = 0;                    ///< of one that is done or has failed
  std::string why;                      ///< it has failed, where no command has said so
  bool cancelled = false;               ///< whatever has become of it
  int starts = 0;                       ///< times that it was started
  nlohmann::json process;               ///< that runs it: see launch.hpp
};

/// Where its command writes: standard output (JSON), standard error, and the dataset.
inline constexpr const char* job_result = "result.json";
inline constexpr const char* job_errors = "errors.txt";
inline constexpr const char* job_output = "dataset";

/// Whether nothing more will happen to it.
bool is_over(JobState state);

/// Its document, job.json.
nlohmann::ordered_json to_json(const Job& job);
/// @throws FileError  it cannot be read
Job read_job(const std::filesystem::path& folder);
/// @throws StorageError
void write_job(const std::filesystem::path& folder, const Job& job);

/// The document with what its folder tells: how far a build is (`progress`, as status.json), what a
/// command that is done has answered (`result`), the last lines of what it complained of
/// (`errors`).
nlohmann::ordered_json describe_job(const std::filesystem::path& folder, const Job& job);

}  // namespace carillon::report::service
