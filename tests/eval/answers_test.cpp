// Files of answers: what was written comes back, and what does not fit together is refused before
// anybody counts with it.
#include "eval/scoring/answers.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/hdf5.hpp"
#include "core/temporary_folder.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon::eval {
namespace {

scoring::Answers two_samples() {
  const scoring::PartAnswers part{{"a", "b"}, {0, 1}, {3, 4}, {5, 6}, {0.5f, -1, 2, 0}};
  return {{"steel", "wood"}, part, part};
}

TEST(AnswersFile, ComesBack) {
  const core::TemporaryFolder folder;
  const std::string path = test::written(folder, "answers.h5", "");
  scoring::write_answers(path, two_samples());
  const scoring::Answers read = scoring::read_answers(path);
  EXPECT_EQ(read.classes, two_samples().classes);
  EXPECT_EQ(read.test.keys, two_samples().test.keys);
  EXPECT_EQ(read.test.scores, two_samples().test.scores);
}

TEST(AnswersFile, IsRefusedWhereLabelsAreNoClasses) {
  const core::TemporaryFolder folder;
  const std::string path = test::written(folder, "answers.h5", "");
  for (const std::int32_t label : {-1, 2}) {
    scoring::Answers answers = two_samples();
    answers.test.labels[1] = label;
    scoring::write_answers(path, answers);
    EXPECT_THROW(scoring::read_answers(path), core::FileError);
  }
}

TEST(AnswersFile, IsRefusedWhereArraysDiffer) {
  const core::TemporaryFolder folder;
  const std::string path = test::written(folder, "answers.h5", "");
  scoring::Answers fewer = two_samples();
  fewer.classes.pop_back();  // two scores of each sample, one class
  fewer.test.labels = fewer.validation.labels = {0, 0};
  scoring::Answers uneven = two_samples();
  uneven.validation.strikes.pop_back();
  for (const scoring::Answers& answers : {fewer, uneven}) {
    {
      const core::Hdf5Group file = core::Hdf5Group::create_file(path);
      file.write<std::string>("classes", answers.classes, {answers.classes.size()});
      for (const auto& [name, part] :
           {std::pair{"validation", &answers.validation}, std::pair{"test", &answers.test}}) {
        const core::Hdf5Group group = file.create_group(name);
        group.write<std::string>("key", part->keys, {part->keys.size()});
        group.write<std::int32_t>("label", part->labels, {part->labels.size()});
        group.write<std::uint32_t>("object", part->objects, {part->objects.size()});
        group.write<std::uint32_t>("strike", part->strikes, {part->strikes.size()});
        group.write<float>("scores", part->scores, {part->scores.size()});
      }
    }
    EXPECT_THROW(scoring::read_answers(path), core::FileError);
  }
}

}  // namespace
}  // namespace carillon::eval
