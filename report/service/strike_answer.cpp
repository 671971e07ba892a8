#include "report/service/strike_answer.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <limits>

#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/quantity_list.hpp"
#include "core/temporary_folder.hpp"
#include "dataset/regenerate/strike_object.hpp"
#include "report/report.hpp"
#include "report/service/job_requests.hpp"
#include "scene/chain.hpp"

namespace carillon::report::service {

namespace fs = std::filesystem;

namespace {

std::string wav_bytes(const StruckInScene& sound) {
  const core::TemporaryFolder folder;
  const fs::path path = folder / "sound.wav";
  core::write_wav(path, scene::clip_of(sound.struck.sound), sound.scene.audio.dtype);
  return core::read_file(path);
}

}  // namespace

const dataset::stored::StoredDataset& StrikeAnswer::open(const fs::path& folder) {
  const auto changed = fs::last_write_time(folder / "configuration.yaml");
  if (!opened_ || opened_->folder != folder || opened_at_ != changed) {
    opened_ = dataset::stored::open_dataset(folder, "");
    opened_at_ = changed;
  }
  return *opened_;
}

HttpReply StrikeAnswer::operator()(const HttpRequest& request) {
  Options options(request);
  const std::string object = options.text("object", "");
  const std::string dataset = options.text("dataset", "");
  const std::string as = options.text("as", "wav");
  scene::SingleStrike strike;
  if (const std::string at = options.text("at", ""); !at.empty()) {
    strike.known.position = core::parse_position(at, "at");
  }
  if (const std::string way = options.text("direction", ""); !way.empty()) {
    const Vec3 direction = core::parse_position(way, "direction");
    if (!(direction.norm() > 0)) throw core::InputError("direction has no length");
    strike.known.direction = direction.normalized();
  }
  strike.seed = options.count("seed", 1, 0, std::numeric_limits<std::int64_t>::max());
  if (object.empty()) {
    throw core::InputError(
        "the query has no object",
        "?object=bowl-003/glass/1 of a dataset, or ?object=bell&material=bronze");
  }
  if (as != "wav" && as != "json") throw core::InputError("as is wav or json");
  const StruckInScene sound = [&]() -> StruckInScene {
    // Shapes that are generated have no dataset.
    if (dataset.empty() && request.query.contains("material")) {
      return shape_(object, options, strike);
    }
    options.finish();
    const auto& opened = open(
        served_dataset(dataset, find_report_folders(folders_, /*may_be_empty=*/true).datasets));
    return {dataset::regenerate::strike_object(opened, object, strike), opened.build.config.scene};
  }();
  if (as == "json") return json_reply(nlohmann::ordered_json(to_json(sound.struck, sound.scene)));
  return {200, "audio/wav", wav_bytes(sound), {}};
}

}  // namespace carillon::report::service
