#include "report/service/detail/newest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/text.hpp"
#include "dataset/run/status.hpp"
#include "report/report.hpp"

namespace carillon::report::service {

namespace {

constexpr std::int64_t usual_count = 4, max_count = 12;
/// Of one sample with its picture, in the reply.
constexpr std::size_t sample_bytes = 400'000;

}  // namespace

HttpReply newest_reply(const HttpRequest& request, const std::vector<std::string>& folders) {
  const auto given = [&](const char* name) {
    const auto at = request.query.find(name);
    return at == request.query.end() ? std::string() : at->second;
  };
  const std::string folder = given("folder");
  const std::vector<std::filesystem::path> datasets = find_report_folders(folders).datasets;
  if (std::find(datasets.begin(), datasets.end(), folder) == datasets.end()) {
    return error_reply(404, fmt::format("there is no dataset \"{}\" here", folder),
                       "folder=... is one of those that /v1/datasets names");
  }
  std::int64_t count = usual_count;
  if (const std::string text = given("count"); !text.empty()) {
    count = core::number_in<std::int64_t>(text).value_or(0);
    if (count < 1 || count > max_count) {
      throw core::InputError(fmt::format(
          "count is \"{}\", and a whole number from 1 to {} is wanted", text, max_count));
    }
  }
  const ReportShare share = {static_cast<std::size_t>(count),
                             static_cast<std::size_t>(count) * sample_bytes};
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
