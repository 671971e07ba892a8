#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "eval/damping/damping_data.hpp"
#include "eval/damping/detail/bounded_newton.hpp"
#include "eval/damping/fit_damping.hpp"

namespace carillon::eval::damping {

/// Of lambda in power laws and hybrids, either sign; omega's is twice as large. Published ones lie
/// between 0 and 1.03.
constexpr double largest_exponent = 4;

/// c of every point with its derivatives by the parameters, in units of a law's scale.
struct Curve {
  Eigen::VectorXd values;
  Eigen::MatrixXd slopes;  ///< points x parameters
};

/// A damping law at the eigenvalues of some data, in parameters x that suit an optimiser: without
/// units, of size one, with bounds that keep damping from being negative where a law demands it.
struct ScaledLaw {
  double scale = 1;  ///< of c [1/s]: the data's median
  Box box;
  /// Not finite where the law is not defined.
  std::function<Curve(const Eigen::VectorXd& x)> curve;
  /// sum over points of weight times second derivatives by the parameters; empty: zero, or not
  /// known.
  std::function<Eigen::MatrixXd(const Eigen::VectorXd& x, const Eigen::VectorXd& weights)> bend;
  /// Parameters that c is linear in while the others stay; all of them: a linear law.
  std::vector<Eigen::Index> linear;
  /// What a search begins with: values of the parameters that c is not linear in; others are 0.
  std::vector<Eigen::VectorXd> candidates;
  std::function<std::vector<double>(const Eigen::VectorXd& x)> alphas;
  std::function<Eigen::VectorXd(const std::vector<double>& alphas)> parameters;
  Eigen::Index size() const { return box.low.size(); }
  bool is_linear() const { return static_cast<Eigen::Index>(linear.size()) == size(); }
};

/// @param along  an alpha, counted from 0, that the parameter of the same place stands for alone:
///               holding the one holds the other. Without it parameters are those in which a search
///               is quickest.
/// @param near   alphas of the size to be expected, for laws whose alphas have sizes of their own
///               (expressions); may be empty
/// @throws InputError  a law that cannot be read or has nothing to be fitted; parameters that the
///                     data's eigenvalues cannot tell apart
ScaledLaw scaled_law(const DampingLaw& law, const DampingData& data,
                     std::optional<std::size_t> along = {}, const std::vector<double>& near = {});

/// How many numbers a law has.
/// @throws InputError  an expression without alphas, or one that leaves one out
std::size_t parameter_count(const DampingLaw& law);

}  // namespace carillon::eval::damping
