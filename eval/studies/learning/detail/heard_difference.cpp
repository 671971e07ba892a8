#include "eval/studies/learning/detail/heard_difference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/numbers.hpp"
#include "eval/features/extract_features.hpp"

namespace carillon::eval::studies {

namespace {

double energy(const perception::HeardSound& sound) {
  return std::inner_product(sound.samples.begin(), sound.samples.end(), sound.samples.begin(), 0.0);
}

/// The other as loud as the reference, by their energies.
void level_out(const perception::HeardSound& reference, perception::HeardSound& other) {
  const double gain = std::sqrt(energy(reference) / energy(other));
  for (double& sample : other.samples) sample *= gain;
  for (features::Feature& mode : other.set.features) mode.amplitude *= gain;
}

constexpr std::size_t numbers = 5;

/// Pitch, decay, level, matched share and loudness of one pair.
std::array<double, numbers> numbers_of(const perception::SoundComparison& comparison) {
  const perception::ModeComparison& modes = comparison.modes;
  return {modes.pitch.mean, modes.decay.mean, modes.level.mean, modes.reference_fraction,
          comparison.loudness.fraction};
}

double median_of_numbers(std::vector<double> values) {
  values.erase(std::remove_if(values.begin(), values.end(), [](double v) { return std::isnan(v); }),
               values.end());
  return values.empty() ? std::numeric_limits<double>::quiet_NaN()
                        : core::median(std::move(values));
}

}  // namespace

KeyedSounds::KeyedSounds(const std::filesystem::path& folder, std::size_t listener)
    : file_(core::Hdf5Group::open_file(folder / "index.h5")), listener_(listener) {
  const core::Extent audio = file_.extent("audio");
  listeners_ = audio.size() == 3 ? static_cast<std::size_t>(audio[1]) : 1;
  const auto keys = file_.read<std::string>("key");
  for (std::size_t row = 0; row < keys.size(); ++row) rows_[keys[row]] = row;
}

std::string KeyedSounds::unit() const {
  return file_.text_attribute("unit", "audio");
}

const perception::HeardSound& KeyedSounds::hear(const std::string& key) {
  if (const auto heard = heard_.find(key); heard != heard_.end()) return heard->second;
  const auto row = rows_.find(key);
  if (row == rows_.end()) throw core::InputError("there is no sound " + key);
  const auto all = file_.read_rows<float>("audio", row->second, 1);
  const std::size_t each = all.size() / listeners_;
  const auto first = all.begin() + static_cast<std::ptrdiff_t>(listener_ * each);
  std::vector<double> samples(first, first + static_cast<std::ptrdiff_t>(each));
  features::FeatureSet set =
      features::extract_features(samples, file_.number_attribute("sample_rate_hz"), {});
  return heard_.emplace(key, perception::HeardSound{std::move(samples), std::move(set)})
      .first->second;
}

nlohmann::ordered_json to_json(const HeardDifference& difference) {
  return {{"sounds", difference.sounds},
          {"pitch_jnd", core::number_or_null(difference.pitch)},
          {"decay_jnd", core::number_or_null(difference.decay)},
          {"level_jnd", core::number_or_null(difference.level)},
          {"matched_fraction", core::number_or_null(difference.matched)},
          {"loudness_fraction", core::number_or_null(difference.loudness)}};
}

HeardDifference heard_difference(KeyedSounds& reference, const std::filesystem::path& other,
                                 const std::vector<std::string>& keys, std::size_t listener,
                                 const networks::LearningRanks& ranks) {
  // Of each sound its numbers, and whether it was compared.
  std::vector<float> found(keys.size() * (numbers + 1), 0.0F);
  std::exception_ptr error;
  try {
    KeyedSounds second(other, listener);
    for (std::size_t k = 0; k < keys.size(); ++k) {
      if (k % static_cast<std::size_t>(ranks.size) != static_cast<std::size_t>(ranks.rank)) {
        continue;
      }
      const perception::HeardSound& one = reference.hear(keys[k]);
      perception::HeardSound two = second.hear(keys[k]);
      if (!(energy(one) > 0 && energy(two) > 0)) continue;
      const bool alike = reference.unit() == second.unit();
      if (!alike) level_out(one, two);
      try {
        auto values = numbers_of(perception::compare_sounds(one, two));
        if (!alike) values[2] = std::numeric_limits<double>::quiet_NaN();
        const auto at = found.begin() + static_cast<std::ptrdiff_t>(k * (numbers + 1));
        *std::transform(values.begin(), values.end(), at,
                        [](double value) { return static_cast<float>(value); }) = 1;
      } catch (const core::InputError&) {
        continue;  // nothing sounds from an onset on
      }
    }
  } catch (...) {
    error = std::current_exception();
  }
  ranks.agree(error);
  ranks.sum(found);
  HeardDifference difference;
  std::array<std::vector<double>, numbers> columns;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (found[k * (numbers + 1) + numbers] == 0) continue;
    ++difference.sounds;
    for (std::size_t n = 0; n < numbers; ++n) {
      columns[n].push_back(found[k * (numbers + 1) + n]);
    }
  }
  difference.pitch = median_of_numbers(columns[0]);
  difference.decay = median_of_numbers(columns[1]);
  difference.level = median_of_numbers(columns[2]);
  difference.matched = median_of_numbers(columns[3]);
  difference.loudness = median_of_numbers(columns[4]);
  return difference;
}

}  // namespace carillon::eval::studies
