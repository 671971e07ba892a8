#include "cli/check/publication.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/build/croissant.hpp"
#include "core/files.hpp"

namespace carillon::cli {

Finding check_publication(const DatasetFolder& folder) {
  const nlohmann::json& stored = folder.dataset.description;
  if (folder.building) return {"publication", Verdict::note, "a build is writing it", "", {}};
  if (!stored.is_object()) return {"publication", Verdict::note, "see configuration", "", {}};
  const std::filesystem::path path = folder.dataset.folder / "croissant.json";
  const std::string remedy = "run the build again into this folder: it writes the file anew";
  if (!std::filesystem::exists(path)) {
    return judged("publication", {"croissant.json is not there"}, "", "it is not described",
                  remedy);
  }
  const About about = about_from(stored.value("about", nlohmann::json::object()));
  const nlohmann::json document = nlohmann::json::parse(core::read_file(path));
  const nlohmann::json head =
      croissant_head(stored.at("name"), about, document.value("description", ""));
  for (const auto& [property, value] : head.items()) {
    if (document.value(property, nlohmann::json()) == value) continue;
    return judged("publication", {fmt::format("croissant.json: {}", property)}, "",
                  "croissant.json does not say what dataset.json does", remedy);
  }
  const std::vector<std::string> missing = missing_keys(about);
  if (missing.empty()) {
    return {
        "publication", Verdict::pass, "croissant.json says all that a publication needs", "", {}};
  }
  return {"publication",
          Verdict::note,
          fmt::format("to be published it lacks {}: keys of `dataset:` in the configuration",
                      fmt::join(missing, ", ")),
          "",
          {}};
}

}  // namespace carillon::cli
