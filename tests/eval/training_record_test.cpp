// training.json: what is written reads back the same.
#include "eval/studies/learning/training_record.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::eval {
namespace {

studies::TrainingRecord network() {
  studies::TrainingRecord record;
  record.key = "geometry/isnn-a/seed-1";
  record.inputs = "b3b8";
  record.source = record.source_folder = "/data/bodies";
  record.source_content = "c28b listener 0";
  record.task = {"geometry", "shape", "split_shape", {{"flat", {"tile", "plate"}}}, {}};
  record.method.name = "isnn-a";
  record.method.branches = {learning::Branch::isnn};
  record.method.modalities = {learning::Modality::spectrogram};
  record.classes = {"bar", "tile"};
  record.train_samples = 80;
  record.test_samples = 20;
  record.learnt = {.parameters = 46318, .epochs = 12, .best_epoch = 12, .training_s = 1.5};
  record.recognition = {.temperature = 1.25, .calibration_error = 0.125};
  record.recognition->unknown["hum"] = {100, 1, {core::nan, core::nan}, 0};
  record.test_accuracy = 0.9;
  record.test_balanced_accuracy = 1;
  record.seconds = 2;
  record.remarks = {"tile is not tested"};
  return record;
}

TEST(TrainingRecord, ReadsBackTheSame) {
  studies::TrainingRecord neighbours = network();
  neighbours.method.kind = learning::MethodKind::nearest_neighbour;
  neighbours.learnt.reset();
  neighbours.recognition.reset();
  for (const studies::TrainingRecord& record : {network(), neighbours}) {
    const std::string text = to_json(record).dump(1);
    const auto back = studies::record_from(nlohmann::json::parse(text));
    EXPECT_EQ(to_json(back).dump(1), text);
    EXPECT_EQ(back.task, record.task);
  }
}

TEST(TrainingRecord, NamesAFileOfAnotherVersion) {
  const core::TemporaryFolder folder;
  core::write_text_durably(folder.path() / "training.json", "{\"key\": \"geometry\"}");
  try {
    studies::read_record(folder.path());
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("training.json is of another version"), std::string::npos)
        << error.message();
  }
}

}  // namespace
}  // namespace carillon::eval
