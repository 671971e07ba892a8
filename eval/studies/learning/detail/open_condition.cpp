#include "eval/studies/learning/detail/open_condition.hpp"

#include <algorithm>
#include <set>

#include "core/random.hpp"

namespace carillon::eval::studies {

using learning::Part;
using learning::Selection;

namespace {

/// A part's samples by the hashes of their keys.
std::vector<Selection> ordered(const OpenCondition& condition, Part part, std::uint32_t number) {
  const auto place = [&](const Selection& one) {
    return std::pair{core::stable_hash("mix " + condition.samples.keys[one.row]), one.row};
  };
  std::vector<Selection> all = condition.part(part, number);
  std::sort(all.begin(), all.end(),
            [&](const Selection& a, const Selection& b) { return place(a) < place(b); });
  return all;
}

}  // namespace

std::vector<Selection> OpenCondition::part(Part part, std::uint32_t number) const {
  std::vector<Selection> some;
  for (const std::uint32_t row : samples.rows(part)) some.push_back({number, row, part});
  return some;
}

std::vector<Selection> OpenCondition::first_of(Part part, std::size_t count,
                                               std::uint32_t number) const {
  std::vector<Selection> some = ordered(*this, part, number);
  some.resize(std::min(count, some.size()));
  return some;
}

std::vector<Selection> OpenCondition::last_of(Part part, std::size_t count,
                                              std::uint32_t number) const {
  std::vector<Selection> some = ordered(*this, part, number);
  some.erase(some.begin(), some.end() - static_cast<std::ptrdiff_t>(std::min(count, some.size())));
  return some;
}

std::vector<std::string> common_keys(const OpenCondition& target, const OpenCondition& other,
                                     std::size_t maximum) {
  const auto names = [](const learning::SampleSource& source) {
    std::vector<std::string> keys = source.keys(), strikes = source.strike_names();
    for (std::size_t i = 0; i < keys.size(); ++i) keys[i] += " " + strikes[i];
    return keys;
  };
  const std::vector<std::string> own = names(*target.source), theirs = names(*other.source);
  const std::set<std::string> there(theirs.begin(), theirs.end());
  std::vector<std::string> common, some;
  for (const std::uint32_t row : target.samples.rows(Part::test)) {
    if (there.count(own[row]) > 0) common.push_back(target.samples.keys[row]);
  }
  const std::size_t count = std::min(maximum, common.size());
  for (std::size_t i = 0; i < count; ++i) some.push_back(common[i * common.size() / count]);
  return some;
}

}  // namespace carillon::eval::studies
