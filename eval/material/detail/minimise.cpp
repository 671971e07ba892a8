#include "eval/material/detail/minimise.hpp"

#include <fmt/format.h>
#include <nlopt.h>

#include <exception>
#include <memory>

#include "core/error.hpp"

namespace carillon::eval::material {

namespace {

/// A C++ exception must not cross NLopt's frames: it is kept and thrown behind them.
struct Call {
  const std::function<double(std::span<const double>)>* function = nullptr;
  nlopt_opt optimiser = nullptr;
  int evaluations = 0;
  std::exception_ptr error;
};

double evaluate(unsigned n, const double* x, double* /*gradient*/, void* data) {
  auto& call = *static_cast<Call*>(data);
  ++call.evaluations;
  try {
    return (*call.function)({x, n});
  } catch (...) {
    call.error = std::current_exception();
    nlopt_force_stop(call.optimiser);
    return 0;
  }
}

}  // namespace

Minimum minimise(const std::function<double(std::span<const double>)>& function,
                 std::vector<double> start, std::span<const double> steps, double tolerance,
                 int max_evaluations) {
  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> optimiser(
      nlopt_create(NLOPT_LN_SBPLX, static_cast<unsigned>(start.size())), &nlopt_destroy);
  Call call{.function = &function, .optimiser = optimiser.get(), .error = {}};
  nlopt_set_min_objective(optimiser.get(), evaluate, &call);
  nlopt_set_initial_step(optimiser.get(), steps.data());
  nlopt_set_ftol_rel(optimiser.get(), tolerance);
  nlopt_set_maxeval(optimiser.get(), max_evaluations);
  Minimum minimum;
  minimum.x = std::move(start);
  const nlopt_result result = nlopt_optimize(optimiser.get(), minimum.x.data(), &minimum.value);
  if (call.error) std::rethrow_exception(call.error);
  // Rounding ends a search as well as a tolerance does.
  if (result < 0 && result != NLOPT_ROUNDOFF_LIMITED) {
    throw core::SolverError(
        fmt::format("the search for a material failed: {}", nlopt_result_to_string(result)));
  }
  minimum.evaluations = call.evaluations;
  minimum.converged = result != NLOPT_MAXEVAL_REACHED;
  return minimum;
}

}  // namespace carillon::eval::material
