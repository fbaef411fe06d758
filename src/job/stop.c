#include "stop.h"

#include <signal.h>
#include <stddef.h>
#include <string.h>

/* Signal handlers know no arguments: the one place where a global cannot be avoided. */
static volatile sig_atomic_t received;

static void remember(int signal) {
  if (!received) received = signal;
}

void hc_stop_catch_signals(void) {
  static const int caught[] = {SIGTERM, SIGUSR1, SIGUSR2};
  struct sigaction action;
  memset(&action, 0, sizeof action);
  action.sa_handler = remember;
  action.sa_flags = SA_RESTART; /* reads and writes go on */
  sigemptyset(&action.sa_mask);
  for (size_t k = 0; k < sizeof caught / sizeof *caught; k++) sigaction(caught[k], &action, NULL);
}

int hc_stop_signal(void) {
  return received;
}

const char *hc_stop_signal_name(int signal) {
  return signal == SIGTERM ? "SIGTERM" : signal == SIGUSR1 ? "SIGUSR1" : "SIGUSR2";
}
