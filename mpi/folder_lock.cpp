#include "mpi/folder_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <sstream>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "core/host_name.hpp"
#include "mpi/comm.hpp"

namespace carillon::mpi {

namespace {

std::string reason(int error) {
  return std::generic_category().message(error);
}

int open_lock_file(const std::filesystem::path& path) {
  // Closed in child programs, which may outlive this process.
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) {
    throw core::FileError(fmt::format("{}: cannot be opened: {}", path.string(), reason(errno)),
                          "the output folder must be writable");
  }
  return file;
}

/// Processes of this host that hold a lock on the file, as Linux lists them; empty elsewhere, and
/// for holders on other hosts.
std::vector<pid_t> holders_here(int file) {
  struct stat status {};
  std::vector<pid_t> found;
  if (fstat(file, &status) != 0) return found;
  const std::string wanted =
      fmt::format("{:02x}:{:02x}:{}", major(status.st_dev), minor(status.st_dev), status.st_ino);
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    // 1: FLOCK  ADVISORY  READ 2207 08:01:1310731 0 EOF; who waits has "->" after the number.
    std::istringstream words(line);
    std::string number, kind, advisory, mode, place;
    pid_t process = 0;
    words >> number >> kind >> advisory >> mode >> process >> place;
    if (words && kind == "FLOCK" && place == wanted && process > 0) found.push_back(process);
  }
  return found;
}

/// "process 123 on host-a", or nothing where the holder has not written it (yet).
std::string read_holder(int file) {
  if (const auto here = holders_here(file); !here.empty()) {
    return fmt::format("process{} {} on {}", here.size() > 1 ? "es" : "", fmt::join(here, ", "),
                       core::host_name());
  }
  std::array<char, 512> text{};
  const ssize_t length = pread(file, text.data(), text.size(), 0);
  std::string holder(text.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  return holder.substr(0, holder.find('\n'));
}

void write_holder(int file) {
  const std::string text = fmt::format("process {} on {}\n", getpid(), core::host_name());
  // For the message of a build that is refused; the lock itself does not need it.
  if (ftruncate(file, 0) != 0 || pwrite(file, text.data(), text.size(), 0) < 0) return;
}

/// What file systems without locks answer: Lustre without -o flock, NFS without a lock service,
/// and some that live in user space.
bool means_no_locks(int error) {
  return error == ENOSYS || error == ENOLCK || error == EOPNOTSUPP;
}

/// @return false where the file system has no locks, and errno says why
bool lock(int file, int kind, const std::filesystem::path& folder, double timeout_s) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  bool told = false;
  while (flock(file, kind | LOCK_NB) != 0) {
    if (errno == EINTR) continue;
    if (means_no_locks(errno)) return false;
    if (errno != EWOULDBLOCK) {
      throw core::FileError(fmt::format("{}: cannot be locked: {}", folder.string(), reason(errno)),
                            "choose another output folder");
    }
    const double waited = std::chrono::duration<double>(Clock::now() - begin).count();
    if (waited < timeout_s) {
      if (waited > 1 && !told) {
        spdlog::warn("{}: waiting for another build to leave this folder ({})", folder.string(),
                     read_holder(file));
        told = true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      continue;
    }
    const std::string holder = read_holder(file);
    throw core::FileError(
        fmt::format("{}: another build is writing to this folder{}", folder.string(),
                    holder.empty() ? "" : fmt::format(" ({})", holder)),
        "wait for it, end it, or choose another output folder");
  }
  return true;
}

/// Files are still renamed into place whole, and two builds of one folder write the same bytes: no
/// reason to refuse.
void warn_of_no_locks(const std::filesystem::path& folder, int error) {
  spdlog::warn(
      "{}: this file system has no locks ({}), so a second build of this folder would not be "
      "noticed; see that there is none (Lustre: mount with -o flock)",
      folder.string(), reason(error));
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder, MPI_Comm comm, double timeout_s) {
  const std::filesystem::path path = folder / ".lock";
  try {
    agreed(comm, [&] {
      if (rank(comm) != 0) return;
      std::error_code error;
      std::filesystem::create_directories(folder, error);
      if (error) {
        throw core::FileError(
            fmt::format("{}: cannot be made: {}", folder.string(), error.message()),
            "choose another output folder");
      }
      file_ = open_lock_file(path);
      // Alone for a moment proves that nobody else is there; then shared, so that others can join.
      // The change is not atomic: a second build may slip in between, and then this one gives way.
      if (!lock(file_, LOCK_EX, folder, timeout_s)) warn_of_no_locks(folder, errno);
      write_holder(file_);
      lock(file_, LOCK_SH, folder, timeout_s);
    });
    agreed(comm, [&] {
      if (rank(comm) == 0) return;
      file_ = open_lock_file(path);
      lock(file_, LOCK_SH, folder, timeout_s);
    });
  } catch (...) {
    if (file_ >= 0) close(file_);
    throw;
  }
}

FolderLock::~FolderLock() {
  if (file_ >= 0) close(file_);
}

bool is_locked(const std::filesystem::path& folder) {
  const int file = open((folder / ".lock").c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool held = flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(file);
  return held;
}

}  // namespace carillon::mpi
