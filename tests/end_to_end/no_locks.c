// Loaded before the C library, makes this machine's file systems like those without locks: flock
// fails with the error number in NO_LOCKS_ERROR.
#include <errno.h>
#include <stdlib.h>

int flock(int file, int operation) {
  (void)file;
  (void)operation;
  const char* error = getenv("NO_LOCKS_ERROR");
  errno = error != NULL ? atoi(error) : ENOSYS;
  return -1;
}
