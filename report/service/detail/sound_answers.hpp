#pragma once

#include <nlohmann/json.hpp>

#include "report/service/answers.hpp"

namespace carillon::report::service {

/// What a clip may be.
struct ClipLimits {
  double seconds = 60;
};

/// Answers for sounds in a request's body, as `carillon COMMAND --json` gives them for files;
/// options are those of the command line, in the query: `?max_features=20&rt60=0.4`.
/// @throws InputError  no sound, one that is too long or of no known format, an option that there
/// is
///                     not or that cannot be read
nlohmann::ordered_json features_of(const HttpRequest& request, const ClipLimits& limits);
nlohmann::ordered_json fit_of(const HttpRequest& request, const ClipLimits& limits);
/// The body is a form with the files `reference` and `other`.
nlohmann::ordered_json comparison_of(const HttpRequest& request, const ClipLimits& limits);
nlohmann::ordered_json identified(const HttpRequest& request, const ClipLimits& limits,
                                  const Identify& identify);

}  // namespace carillon::report::service
