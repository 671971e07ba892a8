#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dataset/stored/stored_dataset.hpp"
#include "report/service/http_message.hpp"
#include "report/service/options.hpp"
#include "scene/single_strike.hpp"

namespace carillon::report::service {

/// A sound of an object that is struck, and the scene that it is in.
struct StruckInScene {
  scene::StruckSound struck;
  scene::Scene scene;
};

/// What strikes an object that is solved first.
/// @param shape  a family with its parameters, no file
using StrikeShape = std::function<StruckInScene(const std::string& shape, Options& options,
                                                const scene::SingleStrike& strike)>;

/// Answers /v1/strike: `object` is a dataset's, or a shape that is generated. The dataset asked
/// last is kept open.
class StrikeAnswer {
 public:
  StrikeAnswer(std::vector<std::string> folders, StrikeShape shape)
      : folders_(std::move(folders)), shape_(std::move(shape)) {}

  /// @return a WAV file, or with `as=json` what is known of the sound
  /// @throws InputError  as the options say
  HttpReply operator()(const HttpRequest& request);

 private:
  const dataset::stored::StoredDataset& open(const std::filesystem::path& folder);

  std::vector<std::string> folders_;
  StrikeShape shape_;
  std::optional<dataset::stored::StoredDataset> opened_;
  std::filesystem::file_time_type opened_at_;  ///< its configuration's
};

}  // namespace carillon::report::service
