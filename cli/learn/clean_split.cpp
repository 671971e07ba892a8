#include "cli/learn/clean_split.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "cli/check/leaks.hpp"
#include "core/error.hpp"

namespace carillon::cli {

void require_clean_split(const std::filesystem::path& folder, const std::string& split) {
  const DatasetFolder opened = open_folder(folder, "");
  const std::vector<Row> rows = read_rows(opened, opened.present);
  const Finding findings[] = {
      split == "split_shape" ? check_split_shape(opened, rows) : check_split_strike(opened, rows),
      check_rooms(rows), check_noise(rows)};
  for (const Finding& finding : findings) {
    if (finding.verdict != Verdict::fail) continue;
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

}  // namespace carillon::cli
