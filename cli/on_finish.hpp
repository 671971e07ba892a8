#pragma once

#include <sys/types.h>

#include <string>

namespace carillon::cli {

/// A command of the shell that runs when this program has ended, however it ends: a process of its
/// own waits for that. The command has CARILLON_EXIT_CODE (137 where the program was killed) and,
/// where there is one, CARILLON_OUTPUT, the output folder.
class OnFinish {
 public:
  OnFinish() = default;
  ~OnFinish();
  OnFinish(const OnFinish&) = delete;
  OnFinish& operator=(const OnFinish&) = delete;

  /// Before there are threads.
  /// @throws FileError  no process can be made
  void watch(const std::string& command);
  /// What the command will be told, if nothing else is noted before the end.
  void note_output(const std::string& folder) const { note("output " + folder); }
  void note_exit(int code) const { note("exit " + std::to_string(code)); }
  /// The program's work has ended: runs the command, and waits for it.
  void finish(int code);

 private:
  void note(std::string line) const;

  int pipe_ = -1;
  pid_t watcher_ = -1;
};

}  // namespace carillon::cli
