#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace carillon::eval::classification {

/// How often samples of each class were taken for each class.
struct Confusion {
  std::size_t classes = 0;
  std::vector<std::size_t> counts;  ///< classes x classes; a row for each true class

  std::size_t at(std::size_t truth, std::size_t predicted) const {
    return counts[truth * classes + predicted];
  }
};

/// @param truth      true class of each sample, from 0
/// @param predicted  the class that it was taken for
/// @return all zeros for no samples
/// @throws InputError  no classes, spans of unequal length, or a class that there is not (names the
///                     sample)
Confusion count_confusion(std::span<const std::size_t> truth,
                          std::span<const std::size_t> predicted, std::size_t classes);

/// Adds what other classifiers of the same classes answered.
void add(Confusion& total, const Confusion& more);

/// Share of all samples that are right; NaN for no samples.
double accuracy(const Confusion& confusion);

/// Share of the samples of each class that are right; NaN for a class that does not occur.
std::vector<double> recalls(const Confusion& confusion);

/// Mean of the recalls of the classes that occur: classes count alike however many samples they
/// have. NaN for no samples.
double balanced_accuracy(const Confusion& confusion);

/// The matrix with rows that sum to 1; NaN in the rows of classes that do not occur.
std::vector<double> row_fractions(const Confusion& confusion);

/// How far two patterns of errors are apart.
struct ConfusionDifference {
  double norm = 0;       ///< Frobenius; NaN where no row is in both
  std::size_t rows = 0;  ///< classes that occur in both, which alone are compared
};

/// Frobenius norm of the element-wise difference of two matrices, as Sterling's dissertation (2019,
/// section 4.3.4.2) compares those of Fig. 4.13, of shares: 0 to sqrt(2 rows), so that sets of
/// different size can be compared. The text does not say which scale its norms (16.03 to 31.85)
/// are of; whole numbers of answers cannot give 31.85. Times 100, shares are percent.
/// @throws InputError  unequal numbers of classes
ConfusionDifference confusion_difference(const Confusion& a, const Confusion& b);

}  // namespace carillon::eval::classification
