#include "eval/networks/detail/linear_machine.hpp"

#include <linear.h>

#include <cstdlib>
#include <memory>

namespace carillon::eval::networks {

double LinearSamples::bytes_of(std::size_t values) {
  return static_cast<double>((values + 2) * sizeof(Node) + sizeof(std::size_t));
}

void LinearSamples::add(std::span<const float> sample, std::int64_t label) {
  first_.push_back(nodes_.size());
  labels_.push_back(label);
  for (std::size_t i = 0; i < sample.size(); ++i) {
    if (sample[i] != 0) nodes_.push_back({static_cast<int>(i) + 1, sample[i]});
  }
  nodes_.push_back({static_cast<int>(values_) + 1, 1.0});  // times the offset
  nodes_.push_back({-1, 0.0});
}

std::vector<double> one_against_rest(LinearSamples& samples, std::int64_t label, double cost,
                                     std::uint64_t seed) {
  static_assert(sizeof(LinearSamples::Node) == sizeof(feature_node));
  std::vector<double> sides;
  std::vector<feature_node*> rows;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    sides.push_back(samples.labels_[i] == label ? 1 : -1);
    rows.push_back(reinterpret_cast<feature_node*>(samples.nodes_.data() + samples.first_[i]));
  }
  problem given{};
  given.l = static_cast<int>(samples.size());
  given.n = static_cast<int>(samples.values_) + 1;
  given.y = sides.data();
  given.x = rows.data();
  given.bias = 1;
  parameter settings{};
  settings.solver_type = L2R_L2LOSS_SVC_DUAL;
  settings.eps = 0.1;  // liblinear's own of this solver
  settings.C = cost;
  set_print_string_function([](const char*) {});
  std::srand(static_cast<unsigned>(seed));  // liblinear draws by rand()
  const auto destroy = [](model* found) { free_and_destroy_model(&found); };
  const std::unique_ptr<model, decltype(destroy)> found(train(&given, &settings), destroy);
  std::vector<double> plane(samples.values_ + 1, 0.0);
  if (found->nr_class < 2) {
    plane.back() = found->label[0];  // all on one side
    return plane;
  }
  // Positive values are of the label that was met first.
  const double sign = found->label[0];
  for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = sign * found->w[i];
  return plane;
}

}  // namespace carillon::eval::networks
