#include "report/service/job_requests.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/config_tree.hpp"
#include "core/error.hpp"
#include "report/service/options.hpp"

namespace carillon::report::service {

namespace fs = std::filesystem;

namespace {

constexpr const char* configuration_name = "configuration.yaml";
constexpr std::size_t largest_configuration = 1 << 20;

/// What a client writes names nothing but what lies in the job's own folder.
void refuse_paths(const core::ConfigTree& tree) {
  const fs::path path(tree.scalar);
  const bool leaves = path.is_absolute() || tree.scalar.starts_with("~") ||
                      std::find(path.begin(), path.end(), "..") != path.end();
  if (tree.kind == core::ConfigTree::Kind::scalar && leaves) {
    throw core::ConfigError(fmt::format("{}: \"{}\" is a file beyond the job's folder",
                                        tree.place.text(configuration_name), tree.scalar),
                            "a job's configuration names no files: shapes by their families, "
                            "datasets by ?dataset=NAME");
  }
  for (const core::ConfigTree& item : tree.items) refuse_paths(item);
  for (const core::ConfigEntry& entry : tree.entries) {
    // A pattern can lead anywhere without a ".." of its own.
    if (entry.key == "glob") {
      throw core::ConfigError(fmt::format("{}: a job's configuration looks for no files",
                                          entry.key_place.text(configuration_name)),
                              "shapes by their families, datasets by ?dataset=NAME");
    }
    refuse_paths(entry.value);
  }
}

const std::string& body_of(const HttpRequest& request, const char* what) {
  const std::string& body =
      request.files.size() == 1 ? request.files.begin()->second : request.body;
  if (body.empty()) {
    throw core::InputError(fmt::format("the request has no {}", what),
                           fmt::format("its body is the {}: curl --data-binary @FILE", what));
  }
  return body;
}

std::string one_of(const std::string& name, const std::string& value,
                   const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), value) == known.end()) {
    throw core::InputError(fmt::format("{} is \"{}\"", name, value),
                           fmt::format("there are {}", fmt::join(known, ", ")));
  }
  return value;
}

}  // namespace

fs::path served_dataset(const std::string& name, const std::vector<fs::path>& datasets) {
  std::vector<fs::path> found;
  for (const fs::path& folder : datasets) {
    if (name.empty() || folder == name || folder.filename() == name) found.push_back(folder);
  }
  if (found.size() == 1) return fs::weakly_canonical(found.front());
  throw core::InputError(found.empty()
                             ? fmt::format("there is no dataset \"{}\" here", name)
                             : fmt::format("{} datasets are here{}", found.size(),
                                           name.empty() ? "" : fmt::format(" called \"{}\"", name)),
                         "dataset is a folder that GET /v1/datasets names");
}

JobRequest command_job(const HttpRequest& request, const JobPlaces& places) {
  Options options(request);
  JobRequest job;
  job.command = one_of("command", options.text("command", "build"), {"build", "train", "evaluate"});
  job.ranks = static_cast<int>(options.count("ranks", places.ranks, 1, places.ranks));
  const std::string dataset = options.text("dataset", "");
  options.finish();
  const std::string& configuration = body_of(request, "configuration");
  if (configuration.size() > largest_configuration) {
    throw core::InputError("the configuration is larger than 1 MiB");
  }
  refuse_paths(core::parse_config_tree(configuration, configuration_name));
  job.files[configuration_name] = configuration;
  job.arguments = {configuration_name, "--output", job_output, "--cache", places.cache};
  if (!dataset.empty()) {
    job.arguments.insert(job.arguments.end(),
                         {"--set", "data=" + served_dataset(dataset, places.datasets).string()});
  }
  return job;
}

JobRequest score_job(const HttpRequest& request, const JobPlaces& places) {
  Options options(request);
  const fs::path dataset = served_dataset(options.text("dataset", ""), places.datasets);
  const std::string task = options.text("task", "");
  const std::string entry = options.text("entry", "");
  const std::string format =
      one_of("format", options.text("format", "csv"), {"csv", "npz", "npy", "parquet"});
  const std::string sealed = options.text("sealed", "");
  options.finish();
  for (const auto& [name, value] : {std::pair{"task", &task}, std::pair{"entry", &entry}}) {
    if (value->empty()) {
      throw core::InputError(fmt::format("the query has no {}", name),
                             "?task=material&entry=NAME, as carillon score --task --name");
    }
  }
  JobRequest job;
  job.command = "score";
  const std::string answers = "answers." + format;
  job.files[answers] = body_of(request, "answers");
  // Values in one word with their options: what begins with a dash is no option of its own.
  job.arguments = {dataset.string(),  "--task=" + task, "--answers", answers,
                   "--name=" + entry, "--cache",        places.cache};
  if (!sealed.empty()) {
    const auto seal = std::find_if(places.seals.begin(), places.seals.end(),
                                   [&](const fs::path& path) { return path.filename() == sealed; });
    if (seal == places.seals.end()) {
      throw core::InputError(fmt::format("there is no seal \"{}\" here", sealed),
                             "carillon serve --sealed FILE");
    }
    job.arguments.insert(job.arguments.end(), {"--sealed", fs::weakly_canonical(*seal).string()});
  }
  return job;
}

}  // namespace carillon::report::service
