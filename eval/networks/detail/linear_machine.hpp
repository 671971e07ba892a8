#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace carillon::eval::networks {

/// Samples that linear machines are found for; zeros take no memory.
class LinearSamples {
 public:
  /// Bytes that a sample without zeros takes.
  static double bytes_of(std::size_t values);

  explicit LinearSamples(std::size_t values) : values_(values) {}
  /// @param sample  as many values as each has
  void add(std::span<const float> sample, std::int64_t label);
  std::size_t size() const { return labels_.size(); }

 private:
  friend std::vector<double> one_against_rest(LinearSamples&, std::int64_t, double, std::uint64_t);
  /// liblinear's feature_node.
  struct Node {
    int index;
    double value;
  };
  std::size_t values_;
  std::vector<Node> nodes_;
  std::vector<std::size_t> first_;  ///< node of each sample
  std::vector<std::int64_t> labels_;
};

/// The plane that has the samples of one label on its positive side: its normal, then its offset
/// (regularised like the normal). Squared hinge loss, by liblinear's dual coordinate descent (Fan
/// et al. 2008), whose random order is of the seed: the same input gives the same bits.
/// @param cost  of a sample on the wrong side, against the normal's square
std::vector<double> one_against_rest(LinearSamples& samples, std::int64_t label, double cost,
                                     std::uint64_t seed);

}  // namespace carillon::eval::networks
