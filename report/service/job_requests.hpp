#pragma once

#include <filesystem>
#include <vector>

#include "report/service/http_message.hpp"
#include "report/service/jobs/job_queue.hpp"

namespace carillon::report::service {

/// What jobs may name beside their own folder.
struct JobPlaces {
  std::vector<std::filesystem::path> datasets;  ///< that are served
  std::vector<std::filesystem::path> seals;     ///< of `carillon export --hide`
  int ranks = 1;                                ///< of a job, at the most and where none are asked
  std::string cache;                            ///< of meshes and modes
};

/// A dataset by its folder or its folder's name; the only one where none is named.
/// @throws InputError  there is none, or there are several
std::filesystem::path served_dataset(const std::string& name,
                                     const std::vector<std::filesystem::path>& datasets);

/// `?command=build&ranks=2&dataset=NAME` with a configuration in the body: of train and evaluate,
/// the dataset stands for the key `data`.
/// @throws InputError, ConfigError  the configuration cannot be read, or names files beyond the
///                                  job's own folder
JobRequest command_job(const HttpRequest& request, const JobPlaces& places);

/// `?dataset=NAME&task=material&entry=mine&format=csv&sealed=FILE` with answers in the body.
/// @throws InputError
JobRequest score_job(const HttpRequest& request, const JobPlaces& places);

}  // namespace carillon::report::service
