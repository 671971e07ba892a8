#include "eval/learning/epochs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/json.hpp"

namespace carillon::eval::learning {

nlohmann::json to_json(const Epoch& epoch) {
  return {{"number", epoch.number},
          {"train_loss", epoch.train_loss},
          {"train_accuracy", epoch.train_accuracy},
          {"validation_loss", core::number_or_null(epoch.validation_loss)},
          {"validation_accuracy", core::number_or_null(epoch.validation_accuracy)},
          {"learning_rate", epoch.learning_rate},
          {"seconds", epoch.seconds},
          {"waited_s", epoch.waited_s},
          {"ranks", epoch.ranks}};
}

Epoch epoch_from(const nlohmann::json& json) {
  const auto number = [&](const char* key) { return core::number_or_nan(json.at(key)); };
  return {.number = json.at("number"),
          .train_loss = json.at("train_loss"),
          .train_accuracy = json.at("train_accuracy"),
          .validation_loss = number("validation_loss"),
          .validation_accuracy = number("validation_accuracy"),
          .learning_rate = json.at("learning_rate"),
          .seconds = json.at("seconds"),
          .waited_s = json.at("waited_s"),
          .ranks = json.at("ranks")};
}

std::int64_t best_of(const std::vector<Epoch>& epochs) {
  std::int64_t best = 0;
  double minimum = std::numeric_limits<double>::infinity();
  for (const Epoch& epoch : epochs) {
    if (std::isnan(epoch.validation_loss) || epoch.validation_loss < minimum) {
      minimum = std::isnan(epoch.validation_loss) ? minimum : epoch.validation_loss;
      best = epoch.number;
    }
  }
  return best;
}

bool ends_after(const std::vector<Epoch>& epochs, const LearningOptions& options) {
  const auto made = static_cast<std::int64_t>(epochs.size());
  if (made >= options.epochs) return true;
  return options.schedule == Schedule::plateau && made - best_of(epochs) >= options.patience;
}

double learning_rate_after(const std::vector<Epoch>& epochs, const LearningOptions& options) {
  if (options.schedule == Schedule::cosine) {
    const double made = static_cast<double>(epochs.size()) / static_cast<double>(options.epochs);
    return options.learning_rate * (1 + std::cos(std::numbers::pi * made)) / 2;
  }
  const std::int64_t half = std::max<std::int64_t>(1, options.patience / 2);
  double rate = options.learning_rate, minimum = std::numeric_limits<double>::infinity();
  std::int64_t since = 0;
  for (const Epoch& epoch : epochs) {
    since = epoch.validation_loss < minimum || std::isnan(epoch.validation_loss) ? 0 : since + 1;
    minimum =
        std::min(minimum, std::isnan(epoch.validation_loss) ? minimum : epoch.validation_loss);
    if (since > 0 && since % half == 0) rate /= 3;
  }
  return rate;
}

}  // namespace carillon::eval::learning
