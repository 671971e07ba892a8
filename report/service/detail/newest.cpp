#include "report/service/detail/newest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "dataset/run/status.hpp"
#include "report/report.hpp"
#include "report/service/options.hpp"

namespace carillon::report::service {

namespace {

constexpr std::size_t usual_count = 4, max_count = 12;
/// Of one sample with its picture, in the reply.
constexpr std::size_t sample_bytes = 400'000;

}  // namespace

HttpReply newest_reply(const HttpRequest& request, const std::vector<std::string>& folders) {
  Options options(request);
  const std::string folder = options.text("folder", "");
  const std::size_t count = options.count("count", usual_count, 1, max_count);
  options.finish();
  const auto datasets = find_report_folders(folders, /*may_be_empty=*/true).datasets;
  if (std::find(datasets.begin(), datasets.end(), folder) == datasets.end()) {
    return error_reply(404, fmt::format("there is no dataset \"{}\" here", folder),
                       "folder=... is one of those that /v1/datasets names");
  }
  const ReportShare share = {count, count * sample_bytes};
  const nlohmann::ordered_json reply = {{"folder", folder},
                                        {"samples", newest_samples(folder, share)}};
  return {200, "application/json", reply.dump() + "\n", {}};
}

bool is_building(const std::vector<std::filesystem::path>& builds) {
  return std::any_of(builds.begin(), builds.end(), [](const std::filesystem::path& folder) {
    try {
      return dataset::run::read_status(folder).at("state") == "running";
    } catch (const core::Error&) {
      return false;
    }
  });
}

}  // namespace carillon::report::service
