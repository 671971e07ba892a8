// Files of answers: what was written comes back, and what does not fit together is refused before
// anybody counts with it.
#include "cli/learn/answers.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "tests/solvers/temporary_folder.hpp"

namespace carillon::cli {
namespace {

Answers two_samples() {
  const PartAnswers part{{"a", "b"}, {0, 1}, {3, 4}, {5, 6}, {0.5f, -1, 2, 0}};
  return {{"steel", "wood"}, part, part};
}

TEST(AnswersFile, ComesBack) {
  const test::TemporaryFolder folder;
  const std::string path = folder.file("answers.h5", "");
  write_answers(path, two_samples());
  const Answers read = read_answers(path);
  EXPECT_EQ(read.classes, two_samples().classes);
  EXPECT_EQ(read.test.keys, two_samples().test.keys);
  EXPECT_EQ(read.test.scores, two_samples().test.scores);
}

TEST(AnswersFile, IsRefusedWhereLabelsAreNoClasses) {
  const test::TemporaryFolder folder;
  const std::string path = folder.file("answers.h5", "");
  for (const std::int32_t label : {-1, 2}) {
    Answers answers = two_samples();
    answers.test.labels[1] = label;
    write_answers(path, answers);
    EXPECT_THROW(read_answers(path), core::FileError);
  }
}

TEST(AnswersFile, IsRefusedWhereThereAreFewerScoresThanClasses) {
  const test::TemporaryFolder folder;
  const std::string path = folder.file("answers.h5", "");
  Answers answers = two_samples();
  answers.classes = {"steel"};
  for (PartAnswers* part : {&answers.validation, &answers.test}) {
    part->scores.resize(2);
    part->labels = {0, 0};
  }
  write_answers(path, answers);
  EXPECT_NO_THROW(read_answers(path));
  answers.validation.keys.pop_back();
  answers.validation.labels.pop_back();
  answers.validation.bodies.pop_back();
  answers.validation.scores.pop_back();
  write_answers(path, answers);  // one strike too many
  EXPECT_THROW(read_answers(path), core::FileError);
}

}  // namespace
}  // namespace carillon::cli
