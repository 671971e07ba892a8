#include "eval/scoring/object_entry.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/did_you_mean.hpp"
#include "core/error.hpp"
#include "core/numbers.hpp"
#include "core/text.hpp"
#include "eval/perception/assignment.hpp"
#include "eval/scoring/detail/first_few.hpp"

namespace carillon::eval::scoring {

namespace {

/// Frequencies further apart are not of the same mode [cents].
constexpr double widest = 100;

/// Where the table has what.
struct ObjectColumns {
  std::size_t name = 0;
  bool is_sample = false;
  std::optional<std::size_t> frequency, decay_rate, alpha1, alpha2;
};

ObjectColumns object_columns(const core::CsvTable& table, ObjectTask task) {
  const std::string asks =
      task == ObjectTask::damping
          ? "object (or sample), and alpha1, alpha2 or frequency_hz, decay_rate_per_s"
          : "object (or sample) and frequency_hz";
  const std::vector<std::string> known =
      task == ObjectTask::damping
          ? std::vector<std::string>{"object",           "sample", "frequency_hz",
                                     "decay_rate_per_s", "alpha1", "alpha2"}
          : std::vector<std::string>{"object", "sample", "frequency_hz"};
  const auto fail = [&](const std::string& what) {
    throw core::InputError(fmt::format("{}: {}", table.head.place, what),
                           fmt::format("the columns are {}", asks));
  };
  for (const std::string& name : table.head.cells) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      fail(
          fmt::format("column \"{}\" means nothing here{}", name, core::did_you_mean(name, known)));
    }
  }
  const auto object = table.column("object"), sample = table.column("sample");
  if (object.has_value() == sample.has_value()) {
    fail("one column \"object\" or \"sample\" says what each row is of");
  }
  ObjectColumns columns{object ? *object : *sample,   sample.has_value(),
                        table.column("frequency_hz"), table.column("decay_rate_per_s"),
                        table.column("alpha1"),       table.column("alpha2")};
  if (task == ObjectTask::modes) {
    if (!columns.frequency) fail("no column \"frequency_hz\"");
    return columns;
  }
  const bool by_law = columns.alpha1 && columns.alpha2;
  const bool by_mode = columns.frequency && columns.decay_rate;
  if (by_law == by_mode || (by_law && (columns.frequency || columns.decay_rate)) ||
      (by_mode && (columns.alpha1 || columns.alpha2))) {
    fail("either alpha1 and alpha2, or frequency_hz and decay_rate_per_s");
  }
  return columns;
}

double number_of(const core::CsvRow& row, std::size_t column, const char* name, bool positive) {
  const std::string text = column < row.cells.size() ? row.cells[column] : "";
  const std::optional<double> value = core::number_in<double>(text);
  if (!value || !std::isfinite(*value) || (positive && !(*value > 0))) {
    throw core::InputError(fmt::format("{}: {} \"{}\" is no {}number", row.place, name, text,
                                       positive ? "positive " : ""));
  }
  return *value;
}

/// What is said of one object by one name: rows in their order.
struct Said {
  std::vector<const core::CsvRow*> rows;
  std::string place() const { return rows.front()->place; }
};

/// The objects whose name a text is, or begins: `cup-3` is of `cup-3/glass/1`.
std::vector<std::size_t> named(const TrueObjects& truth, const std::string& text) {
  std::vector<std::size_t> found;
  for (std::size_t o = 0; o < truth.objects.size(); ++o) {
    const std::string& name = truth.objects[o].name;
    if (name == text || name.starts_with(text + "/")) found.push_back(o);
  }
  return found;
}

std::size_t object_of(const TrueObjects& truth, const std::string& text,
                      const ObjectColumns& columns, const std::string& place) {
  if (columns.is_sample) {
    if (const auto at = truth.sample.find(text); at != truth.sample.end()) return at->second;
    throw core::InputError(
        fmt::format("{}: \"{}\" is no sample of an object that is held out", place, text),
        "samples go by the column `key` of index.h5, or by the ids of a sealed export");
  }
  const std::vector<std::size_t> found = named(truth, text);
  if (found.size() == 1) return found.front();
  std::vector<std::string> names;
  for (const TrueObject& object : truth.objects) names.push_back(object.name);
  if (found.empty()) {
    throw core::InputError(fmt::format("{}: no object \"{}\" is held out{}", place, text,
                                       core::did_you_mean(text, names)),
                           "objects of the test part of split_shape alone are asked");
  }
  throw core::InputError(
      fmt::format("{}: {} is any of {} objects", place, text, found.size()),
      fmt::format("name it as {}", fmt::join({names[found[0]], names[found[1]]}, " or ")));
}

/// Partner of each true mode among frequencies, or perception::unpaired.
std::vector<std::size_t> partners(const TrueObject& object,
                                  const std::vector<double>& frequencies) {
  const std::size_t modes = object.eigenvalues.size();
  std::vector<double> gains(modes * frequencies.size(), 0.0);
  for (std::size_t i = 0; i < modes; ++i) {
    const double own = std::sqrt(object.eigenvalues[i]) / (2 * std::numbers::pi);
    for (std::size_t j = 0; j < frequencies.size(); ++j) {
      const double apart = std::abs(core::cents(frequencies[j] / own));
      // One pair more is worth more than any distance.
      if (apart <= widest) gains[i * frequencies.size() + j] = 2 - apart / widest;
    }
  }
  return perception::best_pairs(gains, modes, frequencies.size());
}

using Numbers = std::vector<double>;

std::vector<double> column_of(const Said& said, std::size_t column, const char* name,
                              bool positive) {
  std::vector<double> values;
  for (const core::CsvRow* row : said.rows) {
    values.push_back(number_of(*row, column, name, positive));
  }
  return values;
}

/// Relative errors of the decay rate at the modes; of both alphas where the law is Rayleigh's.
Numbers damping_errors(const TrueObject& object, const Said& said, const ObjectColumns& columns) {
  const std::size_t modes = object.eigenvalues.size();
  Numbers errors(modes, 1.0);
  Numbers of_alphas = {core::nan, core::nan};
  const auto set = [&](std::size_t mode, double rate) {
    errors[mode] = std::abs(rate / object.decay_rates[mode] - 1);
  };
  if (columns.alpha1) {
    if (said.rows.size() > 1) {
      throw core::InputError(
          fmt::format("one object twice, at {} and {}", said.rows[0]->place, said.rows[1]->place));
    }
    const double alphas[] = {number_of(*said.rows[0], *columns.alpha1, "alpha1", false),
                             number_of(*said.rows[0], *columns.alpha2, "alpha2", false)};
    for (std::size_t m = 0; m < modes; ++m) {
      set(m, (alphas[0] + alphas[1] * object.eigenvalues[m]) / 2);
    }
    for (std::size_t k = 0; k < object.alphas.size() && k < 2; ++k) {
      of_alphas[k] = std::abs(alphas[k] / object.alphas[k] - 1);
    }
  } else {
    const Numbers frequencies = column_of(said, *columns.frequency, "frequency_hz", true);
    const Numbers rates = column_of(said, *columns.decay_rate, "decay_rate_per_s", false);
    const std::vector<std::size_t> partner = partners(object, frequencies);
    for (std::size_t m = 0; m < modes; ++m) {
      if (partner[m] != perception::unpaired) set(m, rates[partner[m]]);
    }
  }
  // Of what does not decay there is no relative error.
  for (std::size_t m = modes; m-- > 0;) {
    if (!(object.decay_rates[m] > 0)) errors.erase(errors.begin() + static_cast<std::ptrdiff_t>(m));
  }
  return {core::median(errors), of_alphas[0], of_alphas[1]};
}

/// Distance of the modes [cent], share of them that has a partner, answers without one per mode.
Numbers mode_errors(const TrueObject& object, const Said& said, const ObjectColumns& columns) {
  const Numbers frequencies = column_of(said, *columns.frequency, "frequency_hz", true);
  const std::vector<std::size_t> partner = partners(object, frequencies);
  Numbers apart;
  double matched = 0;
  for (std::size_t m = 0; m < partner.size(); ++m) {
    if (partner[m] == perception::unpaired) {
      apart.push_back(widest);
      continue;
    }
    const double own = std::sqrt(object.eigenvalues[m]) / (2 * std::numbers::pi);
    apart.push_back(std::abs(core::cents(frequencies[partner[m]] / own)));
    ++matched;
  }
  const auto modes = static_cast<double>(partner.size());
  return {core::median(apart), matched / modes,
          (static_cast<double>(frequencies.size()) - matched) / modes};
}

std::vector<ObjectMeasure> measures_of(ObjectTask task) {
  if (task == ObjectTask::damping) {
    return {{"decay rate error", "%", {}}, {"alpha1 error", "%", {}}, {"alpha2 error", "%", {}}};
  }
  return {{"pitch error", "cent", {}}, {"modes matched", "%", {}}, {"answers too many", "%", {}}};
}

}  // namespace

std::string_view name_of(ObjectTask task) {
  return task == ObjectTask::damping ? "damping" : "modes";
}

ObjectEntry score_objects(const core::CsvTable& table, const std::string& name, ObjectTask task,
                          const TrueObjects& truth) {
  const ObjectColumns columns = object_columns(table, task);
  std::vector<std::map<std::string, Said>> said(truth.objects.size());
  for (const core::CsvRow& row : table.rows) {
    const std::string text = columns.name < row.cells.size() ? row.cells[columns.name] : "";
    said[object_of(truth, text, columns, row.place)][text].rows.push_back(&row);
  }
  ObjectEntry entry{name, {}, measures_of(task), {}};
  std::vector<std::string> missing;
  for (std::size_t o = 0; o < truth.objects.size(); ++o) {
    const TrueObject& object = truth.objects[o];
    if (said[o].empty()) missing.push_back(object.name);
    // An object without modes in the band asks nothing.
    if (said[o].empty() || object.eigenvalues.empty()) continue;
    entry.objects.push_back(object.name);
    std::vector<Numbers> found;
    for (const auto& [text, rows] : said[o]) {
      found.push_back(task == ObjectTask::damping ? damping_errors(object, rows, columns)
                                                  : mode_errors(object, rows, columns));
    }
    for (std::size_t m = 0; m < entry.measures.size(); ++m) {
      Numbers of_sounds;
      for (const Numbers& one : found) of_sounds.push_back(one[m]);
      entry.measures[m].values.push_back(core::median(of_sounds));
    }
  }
  if (!missing.empty()) {
    throw core::InputError(
        fmt::format("{}: {} of {} objects that are held out have no answer: {}", table.head.place,
                    missing.size(), truth.objects.size(), first_few(missing)),
        "every one counts");
  }
  return entry;
}

}  // namespace carillon::eval::scoring
