// carillon-learn: carillon with the commands that need libtorch; carillon starts it.
#include "cli/commands.hpp"
#include "cli/learn/commands.hpp"
#include "cli/learn/sections.hpp"
#include "eval/learning/training.hpp"
#include "mpi/interrupt.hpp"

int main(int argc, char** argv) {
  using namespace carillon;
  mpi::leave_on_interrupt();
  // More ranks with one thread each are faster than one rank with more.
  eval::use_learning_threads(1);
  constexpr cli::EvaluationSection sections[] = {{"damping", cli::read_damping_validation},
                                                 {"classification", cli::read_classification},
                                                 {"transfer", cli::read_transfer_section},
                                                 {"spectrograms", cli::read_spectrograms}};
  return cli::run(argc, argv, {cli::run_train, cli::run_identify, sections});
}
