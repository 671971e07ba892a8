#include "eval/scoring/leaderboard.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/csv.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "core/text.hpp"
#include "eval/scoring/tables.hpp"

namespace carillon::eval::scoring {

using nlohmann::ordered_json;

namespace {

double first_of(const BoardRow& row) {
  return row.measures.front().estimate.mean;
}

ordered_json bounds_json(const core::Range& bounds) {
  if (std::isnan(bounds.low)) return nullptr;
  return {core::number_or_null(bounds.low), core::number_or_null(bounds.high)};
}

ordered_json to_json(const Measure& measure) {
  return {{"name", measure.name},
          {"unit", measure.unit},
          {"mean", core::number_or_null(measure.estimate.mean)},
          {"interval95", bounds_json(measure.estimate.interval95)},
          {"deviation", core::number_or_null(measure.estimate.deviation)}};
}

/// A number of a unit, and its interval where it has one.
std::string told(const Estimate& estimate, const std::string& unit) {
  const double scale = unit == "%" ? 100 : 1;
  const auto number = [&](double value) { return figure(scale * value, 2); };
  if (std::isnan(estimate.interval95.low)) return number(estimate.mean);
  return fmt::format("{} [{}, {}]", number(estimate.mean), number(estimate.interval95.low),
                     number(estimate.interval95.high));
}

/// What a row is beside the first one.
std::string beside_first(const Leaderboard& board, std::size_t r) {
  const BoardRow& row = board.rows[r];
  if (r == 0) return "first";
  if (!row.difference) return "-";
  return told(*row.difference, row.measures.front().unit) +
         (row.is_told_apart ? "" : ", not told apart");
}

}  // namespace

std::filesystem::path entries_folder(const std::filesystem::path& evaluation,
                                     const std::string& task) {
  return evaluation / "scores" / core::file_safe(task);
}

std::vector<std::filesystem::path> kept_entries(const std::filesystem::path& evaluation,
                                                const std::string& task) {
  std::vector<std::filesystem::path> found;
  const std::filesystem::path folder = entries_folder(evaluation, task);
  if (!std::filesystem::is_directory(folder)) return found;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (std::filesystem::is_regular_file(entry.path() / "entry.json"))
      found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

void sort(Leaderboard& board) {
  std::sort(board.rows.begin(), board.rows.end(), [&](const BoardRow& a, const BoardRow& b) {
    const double one = first_of(a), other = first_of(b);
    if (std::isnan(one) != std::isnan(other)) return std::isnan(other);
    if (one != other && !std::isnan(one)) return board.more_is_better ? one > other : one < other;
    return a.entry < b.entry;
  });
}

ordered_json to_json(const Leaderboard& board) {
  ordered_json rows = ordered_json::array();
  for (std::size_t r = 0; r < board.rows.size(); ++r) {
    const BoardRow& row = board.rows[r];
    ordered_json measures = ordered_json::array();
    for (const Measure& measure : row.measures) measures.push_back(to_json(measure));
    rows.push_back({{"rank", r + 1},
                    {"entry", row.entry},
                    {"trained_here", row.is_trained_here},
                    {"seeds", row.seeds},
                    {"measures", measures},
                    {"difference", to_json(row.difference)},
                    {"told_apart", row.is_told_apart}});
  }
  return {{"dataset", board.dataset},
          {"task", board.task},
          {"asked", board.asked},
          {"more_is_better", board.more_is_better},
          {"rows", rows},
          {"notes", board.notes}};
}

std::string to_text(const Leaderboard& board) {
  std::string text = fmt::format("# {}: {}\n\n{}\n\n", board.dataset, board.task, board.asked);
  if (board.rows.empty()) {
    text += "No entries yet.\n";
  } else {
    std::vector<std::vector<std::string>> cells = {{"", "entry", "seeds"}};
    // Rows of classifiers may have a measure less.
    std::vector<std::string> names;
    for (const BoardRow& row : board.rows) {
      for (const Measure& measure : row.measures) {
        if (std::find(names.begin(), names.end(), measure.name) != names.end()) continue;
        names.push_back(measure.name);
        cells.front().push_back(measure.unit.empty()
                                    ? measure.name
                                    : fmt::format("{}, {}", measure.name, measure.unit));
      }
    }
    cells.front().emplace_back("less the first one's");
    for (std::size_t r = 0; r < board.rows.size(); ++r) {
      const BoardRow& row = board.rows[r];
      cells.push_back({fmt::format("{}", r + 1),
                       row.entry + (row.is_trained_here ? " (trained here)" : ""),
                       fmt::format("{}", row.seeds)});
      for (const std::string& name : names) {
        const auto at = std::find_if(row.measures.begin(), row.measures.end(),
                                     [&](const Measure& one) { return one.name == name; });
        cells.back().push_back(at == row.measures.end() ? "-" : told(at->estimate, at->unit));
      }
      cells.back().push_back(beside_first(board, r));
    }
    text += markdown(cells);
  }
  for (const std::string& note : board.notes) text += fmt::format("\n{}\n", note);
  return text;
}

std::string to_csv(const Leaderboard& board) {
  std::string text = core::csv_line({"rank", "entry", "trained_here", "seeds", "measure", "unit",
                                     "mean", "low95", "high95", "difference", "told_apart"});
  const auto number = [](double value) { return core::csv_number(value, 6); };
  for (std::size_t r = 0; r < board.rows.size(); ++r) {
    const BoardRow& row = board.rows[r];
    for (std::size_t m = 0; m < row.measures.size(); ++m) {
      const Measure& measure = row.measures[m];
      const bool compares = m == 0 && row.difference.has_value();
      text += core::csv_line(
          {fmt::format("{}", r + 1), row.entry, row.is_trained_here ? "1" : "0",
           fmt::format("{}", row.seeds), measure.name, measure.unit, number(measure.estimate.mean),
           number(measure.estimate.interval95.low), number(measure.estimate.interval95.high),
           compares ? number(row.difference->mean) : "",
           compares ? (row.is_told_apart ? "1" : "0") : ""});
    }
  }
  return text;
}

void write_board(const Leaderboard& board, const std::filesystem::path& folder) {
  const std::string name = "leaderboard-" + core::file_safe(board.task);
  core::write_text_durably(folder / (name + ".json"), to_json(board).dump(1) + "\n");
  core::write_text_durably(folder / (name + ".csv"), to_csv(board));
  core::write_text_durably(folder / (name + ".md"), to_text(board));
}

}  // namespace carillon::eval::scoring
