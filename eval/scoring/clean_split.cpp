#include "eval/scoring/clean_split.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.hpp"
#include "dataset/check/leaks.hpp"

namespace carillon::eval::scoring {

void require_clean_split(const std::filesystem::path& folder, const std::string& split) {
  const dataset::check::DatasetFolder opened = dataset::check::open_folder(folder, "");
  const std::vector<dataset::check::Row> rows = dataset::check::read_rows(opened, opened.present);
  const dataset::check::Finding findings[] = {
      split == "split_shape" ? dataset::check::check_split_shape(opened, rows)
                             : dataset::check::check_split_strike(opened, rows),
      dataset::check::check_rooms(rows), dataset::check::check_noise(rows)};
  for (const dataset::check::Finding& finding : findings) {
    if (finding.verdict != dataset::check::Verdict::fail) continue;
    throw core::InputError(
        fmt::format(
            "{}: {} leaks from one part into another: {}: {}", folder.string(), split, finding.text,
            fmt::join(finding.items.begin(),
                      finding.items.begin() + static_cast<std::ptrdiff_t>(
                                                  std::min<std::size_t>(3, finding.items.size())),
                      "; ")),
        "what is learnt from it would seem better than it is; carillon check tells all");
  }
}

}  // namespace carillon::eval::scoring
