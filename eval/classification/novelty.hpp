#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "eval/classification/score_rows.hpp"

// Whether a sample is of none of the classes. Scores tell how familiar it is: the greater, the more
// like what was trained on.

namespace carillon::eval {

/// Area under the receiver operating characteristic: the probability that a known sample's score is
/// above a novel one's, equal ones counted half (Mann and Whitney 1947). 0.5: the score tells
/// nothing. Infinite scores are the greatest and the least. NaN where either is empty.
/// @throws InputError  a score that is NaN; names its place
double auroc(std::span<const double> known, std::span<const double> novel);

/// The greatest threshold that at least this share of known samples reaches (score >= threshold).
/// @param rate  true-positive rate, in (0, 1]
/// @throws InputError  no samples, a rate out of range, or a score that is NaN
double threshold_at(std::span<const double> known, double rate);

/// Share of scores that reach a threshold: of novel samples, how many are taken for known. NaN for
/// none.
/// @throws InputError  a score that is NaN
double share_reaching(std::span<const double> scores, double threshold);

/// T log sum exp(z / T) of each row, the free energy's negative (Liu et al. 2020, eq. 4).
/// @throws InputError  as softmax
std::vector<double> energy_scores(const ScoreRows& logits, double temperature = 1);

/// Probability of the predicted class of each row (Hendrycks and Gimpel 2017).
/// @throws InputError  as softmax
std::vector<double> softmax_scores(const ScoreRows& logits, double temperature = 1);

/// Classes as Gaussians of one covariance, in the space where it is the unit matrix.
struct FeatureGaussians {
  Eigen::MatrixXd cholesky;  ///< lower factor of the covariance, columns x columns
  Eigen::MatrixXd centres;   ///< columns x classes that occur, whitened
  double shrinkage = 0;      ///< share of the multiple of the unit matrix in the covariance
};

/// Means of classes and the covariance that they share (Lee et al. 2018, eq. 1), of features of a
/// network's last layer but one. The covariance is drawn towards a multiple of the unit matrix, by
/// Ledoit and Wolf's share (2004) where none is given and by 1e-6 at least, so that it has an
/// inverse of fewer samples than features too. Classes without samples have no Gaussian.
/// @param shrinkage  0 to 1
/// @throws InputError  no samples, features that do not vary within any class, a share out of
/// range,
///                     or as check_rows and check_classes
FeatureGaussians fit_gaussians(const ScoreRows& features, std::span<const std::size_t> truth,
                               std::size_t classes, std::optional<double> shrinkage = {});

/// Mahalanobis distance squared to the nearest centre, with its sign changed (Lee et al. 2018,
/// eq. 2), of each row.
/// @throws InputError  not as many columns as were fitted, or as check_rows
std::vector<double> mahalanobis_scores(const FeatureGaussians& gaussians,
                                       const ScoreRows& features);

}  // namespace carillon::eval
