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
  if (nlohmann::json::parse(core::read_file(path)) !=
      nlohmann::json(dataset_croissant(folder.dataset.folder, stored))) {
    return judged("publication", {"croissant.json"}, "",
                  "croissant.json is not what dataset.json and index.h5 make", remedy);
  }
  const std::vector<std::string> missing =
      missing_keys(about_from(stored.value("about", nlohmann::json::object())));
  if (missing.empty()) {
    return {"publication", Verdict::pass, "croissant.json says all that a publication needs", "",
            {}};
  }
  return {"publication",
          Verdict::note,
          fmt::format("to be published it lacks {}: keys of `dataset:` in the configuration",
                      fmt::join(missing, ", ")),
          "",
          {}};
}

}  // namespace carillon::cli
