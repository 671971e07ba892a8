#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "report/service/http_message.hpp"

namespace carillon::report::service {

/// The samples that a dataset's build made last, as pages hear them: `?folder=FOLDER&count=N`, the
/// folder as /v1/datasets names it.
/// @param folders  that are served
/// @throws InputError  no such count
HttpReply newest_reply(const HttpRequest& request, const std::vector<std::string>& folders);

/// Whether a build is under way in one of them.
bool is_building(const std::vector<std::filesystem::path>& builds);

}  // namespace carillon::report::service
