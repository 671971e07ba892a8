#include "cli/commands.hpp"
#include "cli/learning_commands.hpp"
#include "mpi/interrupt.hpp"

int main(int argc, char** argv) {
  carillon::mpi::leave_on_interrupt();
  carillon::cli::set_libraries_up();
  return carillon::cli::run(argc, argv, carillon::cli::plain_commands());
}
