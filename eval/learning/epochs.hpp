#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "eval/learning/method.hpp"

namespace carillon::eval::learning {

/// One pass over the samples.
struct Epoch {
  std::int64_t number = 0;  ///< from 1
  double train_loss = 0, train_accuracy = 0;
  double validation_loss = 0, validation_accuracy = 0;  ///< NaN without samples for it
  double learning_rate = 0;
  double seconds = 0;   ///< of this rank, with validation
  double waited_s = 0;  ///< of these, for files
  int ranks = 1;
};

/// Losses and accuracies that are no numbers are null.
nlohmann::json to_json(const Epoch& epoch);
Epoch epoch_from(const nlohmann::json& json);

/// The epoch whose weights are kept: of the least validation loss; without samples for it the last;
/// 0 of none.
std::int64_t best_of(const std::vector<Epoch>& epochs);

/// Whether training ends after these epochs.
bool ends_after(const std::vector<Epoch>& epochs, const LearningOptions& options);

/// Of the next epoch, as the options' schedule says.
/// Depends on the epochs alone, so that a training that is resumed goes on as it would have.
double learning_rate_after(const std::vector<Epoch>& epochs, const LearningOptions& options);

}  // namespace carillon::eval::learning
