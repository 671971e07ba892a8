#pragma once

#include "eval/damping/detail/scaled_law.hpp"

namespace carillon::eval::damping {

/// A law c = scale (offset + sum of alpha_k / units_k column_k) without bounds, in parameters of
/// orthogonal columns: nothing is lost where columns resemble each other, as powers of lambda do.
/// @param columns  points x alphas
/// @param along    as of scaled_law()
/// @throws InputError  columns that the points cannot tell apart
ScaledLaw linear_law(const Eigen::MatrixXd& columns, const Eigen::VectorXd& offset,
                     const Eigen::VectorXd& units, std::optional<std::size_t> along);

}  // namespace carillon::eval::damping
