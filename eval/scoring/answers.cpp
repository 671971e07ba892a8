#include "eval/scoring/answers.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hdf5.hpp"
#include "eval/classification/score_rows.hpp"

namespace carillon::eval::scoring {

namespace {

void write_part(const core::Hdf5Group& group, const PartAnswers& part, std::uint64_t classes) {
  const std::uint64_t count = part.samples();
  group.write<std::string>("key", part.keys, {count});
  group.write<std::int32_t>("label", part.labels, {count});
  group.write<std::uint32_t>("object", part.objects, {count});
  group.write<std::uint32_t>("strike", part.strikes, {count});
  group.write<float>("scores", part.scores, {count, classes});
}

PartAnswers read_part(const core::Hdf5Group& group) {
  return {group.read<std::string>("key"), group.read<std::int32_t>("label"),
          group.read<std::uint32_t>("object"), group.read<std::uint32_t>("strike"),
          group.read<float>("scores")};
}

/// Every sample has its label, object, strike and a score for each class, and every label is a
/// class.
bool fits(const PartAnswers& part, std::size_t classes) {
  const std::size_t count = part.samples();
  return part.labels.size() == count && part.objects.size() == count &&
         part.strikes.size() == count && part.scores.size() == count * classes &&
         std::all_of(part.labels.begin(), part.labels.end(), [&](std::int32_t label) {
           return label >= 0 && static_cast<std::size_t>(label) < classes;
         });
}

}  // namespace

PartAnswers asked(const learning::LabelledSamples& samples,
                  const std::vector<std::uint32_t>& rows) {
  PartAnswers part;
  for (const std::uint32_t row : rows) {
    part.keys.push_back(samples.keys[row]);
    part.labels.push_back(samples.label[row]);
    part.objects.push_back(samples.object_groups[row]);
    part.strikes.push_back(samples.strike_groups[row]);
  }
  return part;
}

std::vector<std::size_t> true_classes(const PartAnswers& part) {
  return {part.labels.begin(), part.labels.end()};
}

std::vector<std::size_t> likely_classes(const PartAnswers& part, std::size_t classes) {
  const std::vector<double> scores(part.scores.begin(), part.scores.end());
  return classification::predicted_classes({scores, classes});
}

std::vector<std::size_t> groups_of(const PartAnswers& part, const std::string& split) {
  const auto& groups = split == "split_shape" ? part.objects : part.strikes;
  return {groups.begin(), groups.end()};
}

classification::Confusion confusion_of(const PartAnswers& part, std::size_t classes) {
  return classification::count_confusion(true_classes(part), likely_classes(part, classes),
                                         classes);
}

void write_answers(const std::filesystem::path& path, const Answers& answers) {
  core::write_durably(path, [&](const std::filesystem::path& temporary) {
    const core::Hdf5Group file = core::Hdf5Group::create_file(temporary);
    const std::uint64_t classes = answers.classes.size();
    file.write<std::string>("classes", answers.classes, {classes});
    write_part(file.create_group("validation"), answers.validation, classes);
    write_part(file.create_group("test"), answers.test, classes);
    file.flush();
  });
}

Answers read_answers(const std::filesystem::path& path) {
  const core::Hdf5Group file = core::Hdf5Group::open_file(path);
  Answers answers{file.read<std::string>("classes"), read_part(file.open_group("validation")),
                  read_part(file.open_group("test"))};
  if (!fits(answers.validation, answers.classes.size()) ||
      !fits(answers.test, answers.classes.size())) {
    throw core::FileError(
        fmt::format("{}: arrays of the answers do not fit together", path.string()),
        fmt::format("remove {}: the training is run again", path.parent_path().string()));
  }
  return answers;
}

}  // namespace carillon::eval::scoring
