#include "eval/scoring/seed_answers.hpp"

#include <algorithm>
#include <set>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/numbers.hpp"
#include "core/random.hpp"

namespace carillon::eval::scoring {

nlohmann::ordered_json to_json(const std::optional<Estimate>& estimate) {
  if (!estimate) return nullptr;
  return {{"mean", core::number_or_null(estimate->mean)},
          {"interval95",
           {core::number_or_null(estimate->interval95.low),
            core::number_or_null(estimate->interval95.high)}}};
}

nlohmann::ordered_json accuracy_json(const std::optional<Estimate>& accuracy) {
  nlohmann::ordered_json found = to_json(accuracy);
  if (accuracy) found["deviation"] = core::number_or_null(accuracy->deviation);
  return found;
}

nlohmann::ordered_json counts_json(const classification::Confusion& confusion) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (std::size_t c = 0; c < confusion.classes; ++c) {
    nlohmann::ordered_json& counts = rows.emplace_back(nlohmann::ordered_json::array());
    for (std::size_t k = 0; k < confusion.classes; ++k) counts.push_back(confusion.at(c, k));
  }
  return rows;
}

void SeedAnswers::add(const PartAnswers& part, const std::vector<std::string>& names) {
  const std::size_t classes = names.size();
  if (predicted_.empty()) {
    keys_ = part.keys;
    classes_ = names;
    truth_ = true_classes(part);
    groups_ = groups_of(part, split_);
    confusion_ = confusion_of(part, classes);
  } else {
    if (part.keys != keys_ || names != classes_) {
      throw core::InputError("seeds of one method answered for different samples",
                             "a folder of models was changed; delete it, and it is trained again");
    }
    classification::add(confusion_, confusion_of(part, classes));
  }
  predicted_.push_back(likely_classes(part, classes));
}

std::size_t SeedAnswers::groups() const {
  return std::set(groups_.begin(), groups_.end()).size();
}

std::optional<Estimate> SeedAnswers::summary(classification::AccuracyKind kind,
                                             const std::string& inputs) const {
  if (empty()) return std::nullopt;
  const classification::SeedsSummary seeds =
      classification::interval_over_seeds(tested(), predicted_, kind);
  core::Range bounds = seeds.seeds_and_groups;
  if (predicted_.size() == 1) {
    core::RandomStream random(0, core::stable_hash(inputs), "evaluate.classification");
    bounds = classification::grouped_interval(tested(), predicted_.front(), kind, random);
  }
  return Estimate{seeds.mean, bounds, seeds.deviation};
}

std::optional<Estimate> SeedAnswers::less(const SeedAnswers& others,
                                          classification::AccuracyKind kind,
                                          double probability) const {
  if (empty() || others.keys_ != keys_) return std::nullopt;
  // What others alone know is one class more, and wrong here.
  std::vector<std::size_t> own_number;
  for (const std::string& name : others.classes_) {
    own_number.push_back(static_cast<std::size_t>(
        std::find(classes_.begin(), classes_.end(), name) - classes_.begin()));
  }
  std::vector<std::vector<std::size_t>> theirs = others.predicted_;
  for (std::vector<std::size_t>& predicted : theirs) {
    for (std::size_t& answer : predicted) answer = own_number[answer];
  }
  classification::TestedSamples all = tested();
  all.classes += 1;
  const classification::AccuracyDifference difference =
      classification::accuracy_difference(all, predicted_, theirs, kind, probability);
  return Estimate{difference.mean, difference.bounds};
}

classification::NormByChance SeedAnswers::norm_by_chance(const SeedAnswers& others) const {
  core::RandomStream random(0, 0, "evaluate.confusions");
  return classification::confusion_norm_by_chance({tested(), predicted_},
                                                  {others.tested(), others.predicted_}, random);
}

}  // namespace carillon::eval::scoring
