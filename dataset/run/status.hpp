#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace carillon::dataset::run {

/// In the folder of a dataset or a sweep: how far the build is that writes it, or how the last one
/// ended (docs/format.md, status.json).
inline constexpr const char* status_name = "status.json";

/// What a folder's status.json says, with what its ranks are busy with as `running` (`rank`,
/// `task`, `stage`, `item` each). A build that is said to run and whose processes are gone has the
/// state "lost".
/// @throws InputError  there is none, or it cannot be read
nlohmann::ordered_json read_status(const std::filesystem::path& folder);

/// For a person; lines.
std::string status_text(const nlohmann::ordered_json& status);
/// The same in one line.
std::string status_line(const nlohmann::ordered_json& status);

/// Now, as "2026-03-31T14:05:09Z".
std::string utc_date();

}  // namespace carillon::dataset::run
