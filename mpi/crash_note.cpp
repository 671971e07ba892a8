#include "mpi/crash_note.hpp"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <memory>

#include "core/error.hpp"

namespace carillon::mpi {

namespace {

struct Noted {
  int signal;
  const char* name;
};
constexpr std::array<Noted, 5> noted{{{SIGSEGV, "SIGSEGV"},
                                      {SIGBUS, "SIGBUS"},
                                      {SIGFPE, "SIGFPE"},
                                      {SIGILL, "SIGILL"},
                                      {SIGABRT, "SIGABRT"}}};

// What a signal handler can reach. The handlers themselves belong to the process, so this does too.
std::atomic<int> note_file{-1};
std::atomic<off_t> note_offset{0};
std::array<struct sigaction, noted.size()> former{};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<off_t>::is_always_lock_free,
              "a signal handler may touch nothing else");

/// Nothing here but what is safe in a handler: pwrite and sigaction.
extern "C" void note_crash(int signal) {
  for (std::size_t i = 0; i < noted.size(); ++i) {
    if (noted[i].signal != signal) continue;
    std::array<char, 16> line{};
    std::size_t length = 0;
    while (noted[i].name[length] != '\0') {
      line[length] = noted[i].name[length];
      ++length;
    }
    line[length++] = '\n';
    const int file = note_file.load();
    if (file >= 0 && pwrite(file, line.data(), length, note_offset.load()) < 0) {
      // There is nobody left to tell.
    }
    // The fault comes again on return, and now meets whoever was there before. An abort that was
    // called for, or a signal that was sent, does not, and is raised once more.
    sigaction(signal, &former[i], nullptr);
    raise(signal);
    return;
  }
}

/// A stack of its own for handlers of one thread: its usual one may be what overflowed.
class HandlerStack {
 public:
  HandlerStack() : memory_(new std::byte[size]) {
    stack_t stack{};
    stack.ss_sp = memory_.get();
    stack.ss_size = size;
    sigaltstack(&stack, &former_);
  }
  ~HandlerStack() { sigaltstack(&former_, nullptr); }
  HandlerStack(const HandlerStack&) = delete;
  HandlerStack& operator=(const HandlerStack&) = delete;

 private:
  static constexpr std::size_t size = 64 << 10;
  std::unique_ptr<std::byte[]> memory_;
  stack_t former_{};
};

std::unique_ptr<HandlerStack>& handler_stack() {
  static std::unique_ptr<HandlerStack> stack;
  return stack;
}

}  // namespace

CrashNote::CrashNote(int file, off_t offset) {
  if (note_file.load() >= 0) throw core::Error("two notes of crashes at a time");
  note_offset.store(offset);
  note_file.store(file);
  handler_stack() = std::make_unique<HandlerStack>();
  for (std::size_t i = 0; i < noted.size(); ++i) {
    struct sigaction action {};
    action.sa_handler = note_crash;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_ONSTACK;
    sigaction(noted[i].signal, &action, &former[i]);
  }
}

CrashNote::~CrashNote() {
  for (std::size_t i = 0; i < noted.size(); ++i) sigaction(noted[i].signal, &former[i], nullptr);
  handler_stack().reset();
  note_file.store(-1);
}

}  // namespace carillon::mpi
