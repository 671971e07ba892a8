// carillon-learn: carillon with the commands that need libtorch; carillon starts it.
#include "cli/commands.hpp"
#include "cli/learning_commands.hpp"
#include "eval/networks/training.hpp"
#include "eval/studies/learning/sections.hpp"
#include "mpi/interrupt.hpp"

int main(int argc, char** argv) {
  using namespace carillon;
  mpi::leave_on_interrupt();
  cli::set_libraries_up();
  // More ranks with one thread each are faster than one rank with more.
  eval::networks::set_up_learning(1);
  constexpr eval::studies::EvaluationSection sections[] = {
      {"damping", eval::studies::read_damping_validation},
      {"classification", eval::studies::read_classification},
      {"transfer", eval::studies::read_transfer_section},
      {"spectrograms", eval::studies::read_spectrograms}};
  return cli::run(argc, argv, {cli::run_train, cli::run_identify, cli::make_identifier, sections});
}
