#include "dataset/check/values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/hdf5.hpp"
#include "core/numbers.hpp"
#include "scene/columns.hpp"

namespace carillon::dataset::check {

using core::Hdf5Group;

namespace {

/// Values that are read at once.
constexpr std::uint64_t values_at_once = 1 << 22;

/// Calls take(row, values of the row) for every row of a column.
template <class T, class Take>
void each_row(const Hdf5Group& file, const std::string& column, const Take& take) {
  const core::Extent extent = file.extent(column);
  std::uint64_t width = 1;
  for (std::size_t axis = 1; axis < extent.size(); ++axis) width *= extent[axis];
  const std::uint64_t step =
      std::max<std::uint64_t>(1, values_at_once / std::max<std::uint64_t>(1, width));
  for (std::uint64_t from = 0; from < extent.front(); from += step) {
    const std::uint64_t rows = std::min(step, extent.front() - from);
    const std::vector<T> values = file.read_rows<T>(column, from, rows);
    for (std::uint64_t row = 0; row < rows; ++row) {
      take(from + row, std::span<const T>(values).subspan(row * width, width));
    }
  }
}

struct Scan {
  const Hdf5Group& file;
  std::vector<std::string> keys;
  ValueScan found{.samples = keys.size()};

  void note(std::vector<std::string>& list, std::uint64_t row, const std::string& text) const {
    list.push_back(fmt::format("{}{}", keys[row], text));
  }

  template <class T>
  void finite(const std::string& column, bool may_be_nan) {
    each_row<T>(file, column, [&](std::uint64_t row, std::span<const T> values) {
      const auto bad = std::find_if(values.begin(), values.end(), [&](T value) {
        return std::isinf(value) || (std::isnan(value) && !may_be_nan);
      });
      if (bad != values.end()) note(found.broken, row, fmt::format(": {} holds {}", column, *bad));
    });
  }

  /// Recorded peaks and clipping against the audio.
  void audio_float(const std::vector<double>& peaks) {
    each_row<float>(file, "audio", [&](std::uint64_t row, std::span<const float> values) {
      const double peak = core::peak(values);
      if (peak == 0) note(found.silent, row, "");
      if (std::isfinite(peak) && peak != peaks[row]) {
        note(found.broken, row, fmt::format(": peak is {}, the audio's is {}", peaks[row], peak));
      }
    });
  }

  void audio_int16(const std::vector<double>& peaks, const std::vector<std::int64_t>& counts) {
    constexpr int low = std::numeric_limits<std::int16_t>::min(),
                  high = std::numeric_limits<std::int16_t>::max();
    each_row<std::int16_t>(
        file, "audio", [&](std::uint64_t row, std::span<const std::int16_t> values) {
          int peak = 0;
          std::int64_t full = 0;
          for (const std::int16_t value : values) {
            peak = std::max(peak, std::abs(static_cast<int>(value)));
            full += value == low || value == high ? 1 : 0;
          }
          if (peak == 0) note(found.silent, row, "");
          if (counts[row] > 0) note(found.clipped, row, fmt::format(": {} samples", counts[row]));
          if (counts[row] < 0 || counts[row] > full) {
            note(found.broken, row,
                 fmt::format(": clipped says {}, {} samples are at full scale", counts[row], full));
          }
          // A peak of either sign: full scale is -32,768 to 32,767.
          const double wanted = std::min(std::nearbyint(peaks[row] * -low), -1.0 * low);
          if (std::abs(wanted - peak) > 1) {
            note(found.broken, row,
                 fmt::format(": peak is {}, the audio's is {}", peaks[row],
                             static_cast<double>(peak) / -low));
          }
        });
  }
};

}  // namespace

ValueScan scan_values(const std::filesystem::path& shard) {
  const Hdf5Group file = Hdf5Group::open_file(shard);
  Scan scan{file, file.read<std::string>("key")};
  for (const std::string& column : file.names()) {
    const core::ColumnRule* rule = core::find_rule(scene::columns(), column);
    const std::string type = file.element_type(column);
    const bool may_be_nan = rule != nullptr && rule->may_be_nan;
    if (type == "float32") scan.finite<float>(column, may_be_nan);
    if (type == "float64") scan.finite<double>(column, may_be_nan);
  }
  const auto peaks = file.read<double>("peak");
  if (file.element_type("audio") == "int16") {
    scan.audio_int16(peaks, file.read<std::int64_t>("clipped"));
  } else {
    scan.audio_float(peaks);
  }
  return scan.found;
}

std::vector<Finding> judge_values(const std::vector<ValueScan>& scans) {
  std::size_t samples = 0;
  std::vector<std::string> broken, clipped, silent;
  const auto add = [](const std::vector<std::string>& some, std::vector<std::string>& all) {
    all.insert(all.end(), some.begin(), some.end());
  };
  for (const ValueScan& scan : scans) {
    samples += scan.samples;
    add(scan.broken, broken);
    add(scan.clipped, clipped);
    add(scan.silent, silent);
  }
  const std::size_t faults = broken.size(), clips = clipped.size(), silences = silent.size();
  const auto noted = [](const std::string& check, std::vector<std::string> items,
                        const std::string& passed, const std::string& found) {
    const Verdict verdict = items.empty() ? Verdict::pass : Verdict::note;
    return Finding{check, verdict, items.empty() ? passed : found, "", std::move(items)};
  };
  return {judged("values", std::move(broken),
                 fmt::format("all values of {} samples are finite and fit", samples),
                 fmt::format("{} faults in {} samples", faults, samples),
                 "delete these shards and run the build again into this folder"),
          noted("clipping", std::move(clipped), "no sample is clipped",
                fmt::format("{} of {} samples are clipped", clips, samples)),
          noted("silence", std::move(silent), "no sample is silent",
                fmt::format("{} of {} samples hold nothing but zeros", silences, samples))};
}

}  // namespace carillon::dataset::check
