/* A fault in the middle of a solve, for tests: preloaded, it stands before CHOLMOD's factorisation
 * and, for bodies of at least FAULT_FROM unknowns, does what FAULT says first: segv, abort, hang,
 * or a number of seconds to wait before all goes on as usual. With "fat", mpirun's first rank holds
 * 2 GiB more than it needs from its start. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void *held;

__attribute__((constructor)) static void grow_fat(void) {
  const char *fault = getenv("FAULT");
  const char *rank = getenv("OMPI_COMM_WORLD_RANK");
  if (fault && rank && strcmp(fault, "fat") == 0 && strcmp(rank, "0") == 0)
    held = malloc((size_t)2 << 30);
}

int cholmod_l_factorize(void *matrix, void *factor, void *common) {
  int (*real)(void *, void *, void *) =
      (int (*)(void *, void *, void *))dlsym(RTLD_NEXT, "cholmod_l_factorize");
  const char *fault = getenv("FAULT");
  const char *from = getenv("FAULT_FROM");
  /* A factor begins with its number of rows. */
  size_t rows = *(size_t *)factor;
  if (fault && from && rows >= (size_t)atol(from)) {
    if (strcmp(fault, "segv") == 0) *(volatile int *)0 = 0;
    if (strcmp(fault, "abort") == 0) abort();
    if (strcmp(fault, "hang") == 0)
      for (;;) sleep(1);
    usleep((useconds_t)(1e6 * atof(fault)));
  }
  return real(matrix, factor, common);
}
