#include "eval/classification/confusion_chance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/classification/confusion.hpp"

namespace carillon::eval::classification {

namespace {

/// Answers of one group: a row of counts for each class that it has samples of.
using Group = std::map<std::size_t, std::vector<std::size_t>>;

/// Groups that are dealt among themselves, those of the first set before the others'.
struct Dealt {
  std::vector<Group> groups;
  std::size_t of_first = 0;
};

std::map<std::size_t, Group> groups_of(const AnsweredSamples& set) {
  const auto& [truth, groups, classes] = set.tested;
  if (groups.size() != truth.size()) {
    throw core::InputError(fmt::format("{} groups of {} samples", groups.size(), truth.size()));
  }
  std::map<std::size_t, Group> found;
  for (const std::vector<std::size_t>& predicted : set.predicted) {
    count_confusion(truth, predicted, classes);  // refuses what cannot be counted
    for (std::size_t i = 0; i < truth.size(); ++i) {
      std::vector<std::size_t>& row = found[groups[i]][truth[i]];
      row.resize(classes);
      ++row[predicted[i]];
    }
  }
  return found;
}

std::vector<std::size_t> classes_of(const Group& group) {
  std::vector<std::size_t> classes;
  for (const auto& [truth, row] : group) classes.push_back(truth);
  return classes;
}

/// A group on both sides is dealt with its other self. Others with samples of the same classes are
/// dealt among themselves, so that each side keeps its number of each; those with classes of which
/// only one side has groups, all together.
std::vector<Dealt> strata_of(const AnsweredSamples& first, const AnsweredSamples& second) {
  std::vector<Dealt> strata(1);
  std::map<std::vector<std::size_t>, std::vector<Group>> sides[2];
  std::map<std::size_t, Group> others_of_second = groups_of(second);
  for (auto& [name, group] : groups_of(first)) {
    if (const auto other = others_of_second.extract(name)) {
      strata.push_back({{group, other.mapped()}, 1});
    } else {
      sides[0][classes_of(group)].push_back(group);
    }
  }
  for (auto& [name, group] : others_of_second) sides[1][classes_of(group)].push_back(group);
  const auto append = [](std::vector<Group>& all, const std::vector<Group>& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  for (const auto& [classes, groups] : sides[0]) {
    const auto others = sides[1].find(classes);
    const bool alone = others == sides[1].end();
    Dealt& dealt = alone ? strata.front() : strata.emplace_back();
    append(dealt.groups, groups);
    dealt.of_first += groups.size();
    if (alone) continue;
    append(dealt.groups, others->second);
    sides[1].erase(others);
  }
  for (const auto& [classes, groups] : sides[1]) append(strata.front().groups, groups);
  return strata;
}

ConfusionDifference difference_of(const std::vector<Dealt>& strata, std::size_t classes) {
  Confusion sides[2];
  for (Confusion& side : sides) side = {classes, std::vector<std::size_t>(classes * classes)};
  for (const Dealt& dealt : strata) {
    for (std::size_t g = 0; g < dealt.groups.size(); ++g) {
      Confusion& side = sides[g < dealt.of_first ? 0 : 1];
      for (const auto& [truth, row] : dealt.groups[g]) {
        for (std::size_t c = 0; c < classes; ++c) side.counts[truth * classes + c] += row[c];
      }
    }
  }
  return confusion_difference(sides[0], sides[1]);
}

void shuffle(std::vector<Group>& groups, core::RandomStream& random) {
  for (std::size_t i = groups.size(); i > 1; --i) {
    std::swap(groups[i - 1], groups[random.index(i)]);
  }
}

}  // namespace

NormByChance confusion_norm_by_chance(const AnsweredSamples& first, const AnsweredSamples& second,
                                      core::RandomStream& random, std::size_t draws) {
  const std::size_t classes = first.tested.classes;
  if (second.tested.classes != classes) {
    throw core::InputError(
        fmt::format("confusion matrices of {} and of {} classes cannot be compared", classes,
                    second.tested.classes));
  }
  std::vector<Dealt> strata = strata_of(first, second);
  if (draws == 0 || difference_of(strata, classes).rows == 0) return {core::nan, core::nan};
  std::vector<double> norms;
  double sum = 0;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    for (Dealt& dealt : strata) shuffle(dealt.groups, random);
    const ConfusionDifference difference = difference_of(strata, classes);
    norms.push_back(difference.rows == 0 ? 0 : difference.norm);
    sum += norms.back();
  }
  const auto count = static_cast<double>(draws);
  const auto place = static_cast<std::ptrdiff_t>(std::ceil(0.95 * count)) - 1;
  std::nth_element(norms.begin(), norms.begin() + place, norms.end());
  return {sum / count, norms[static_cast<std::size_t>(place)]};
}

}  // namespace carillon::eval::classification
