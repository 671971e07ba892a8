#include "eval/classification/confusion_chance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/error.hpp"
#include "eval/classification/confusion.hpp"

namespace carillon::eval {

namespace {

/// What the samples of one class and group were taken for: a count for each class.
using Answers = std::vector<std::size_t>;

/// The groups of one class that occurs in both sets, those of the first set before the others'.
struct Dealt {
  std::vector<Answers> groups;
  std::size_t of_first = 0;
};

/// Groups of each class, in the order of their numbers.
std::vector<std::vector<Answers>> groups_of_classes(const AnsweredSamples& set) {
  const auto& [truth, groups, classes] = set.tested;
  std::vector<std::map<std::size_t, Answers>> by_class(classes);
  for (const std::vector<std::size_t>& predicted : set.predicted) {
    count_confusion(truth, predicted, classes);  // refuses what cannot be counted
    for (std::size_t i = 0; i < truth.size(); ++i) {
      Answers& answers = by_class[truth[i]][groups[i]];
      answers.resize(classes);
      ++answers[predicted[i]];
    }
  }
  std::vector<std::vector<Answers>> found(classes);
  for (std::size_t c = 0; c < classes; ++c) {
    for (auto& [group, answers] : by_class[c]) found[c].push_back(std::move(answers));
  }
  return found;
}

/// Square of the distance of the two rows of shares.
double squared_distance(const Dealt& dealt, std::size_t classes) {
  std::vector<double> rows[2] = {std::vector<double>(classes), std::vector<double>(classes)};
  double totals[2] = {0, 0};
  for (std::size_t g = 0; g < dealt.groups.size(); ++g) {
    const int side = g < dealt.of_first ? 0 : 1;
    for (std::size_t c = 0; c < classes; ++c) {
      rows[side][c] += static_cast<double>(dealt.groups[g][c]);
      totals[side] += static_cast<double>(dealt.groups[g][c]);
    }
  }
  double square = 0;
  for (std::size_t c = 0; c < classes; ++c) {
    const double apart = rows[0][c] / totals[0] - rows[1][c] / totals[1];
    square += apart * apart;
  }
  return square;
}

void shuffle(std::vector<Answers>& groups, core::RandomStream& random) {
  for (std::size_t i = groups.size(); i > 1; --i) {
    std::swap(groups[i - 1], groups[random.index(i)]);
  }
}

}  // namespace

NormByChance confusion_norm_by_chance(const AnsweredSamples& first, const AnsweredSamples& second,
                                      core::RandomStream& random, int draws) {
  const std::size_t classes = first.tested.classes;
  if (second.tested.classes != classes) {
    throw core::InputError(
        fmt::format("confusion matrices of {} and of {} classes cannot be compared", classes,
                    second.tested.classes));
  }
  const auto of_first = groups_of_classes(first), of_second = groups_of_classes(second);
  std::vector<Dealt> compared;
  for (std::size_t c = 0; c < classes; ++c) {
    if (of_first[c].empty() || of_second[c].empty()) continue;
    compared.push_back({of_first[c], of_first[c].size()});
    compared.back().groups.insert(compared.back().groups.end(), of_second[c].begin(),
                                  of_second[c].end());
  }
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (compared.empty()) return {nan, nan};
  std::vector<double> norms;
  double sum = 0;
  for (int draw = 0; draw < draws; ++draw) {
    double squares = 0;
    for (Dealt& dealt : compared) {
      shuffle(dealt.groups, random);
      squares += squared_distance(dealt, classes);
    }
    norms.push_back(std::sqrt(squares));
    sum += norms.back();
  }
  const auto place = static_cast<std::ptrdiff_t>(std::ceil(0.95 * draws)) - 1;
  std::nth_element(norms.begin(), norms.begin() + place, norms.end());
  return {sum / draws, norms[static_cast<std::size_t>(place)]};
}

}  // namespace carillon::eval
