#include "ending.h"

#include "base/check.h"
#include "calls.h"
#include "halocline/error.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const int fatal[] = {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL};
enum { FATAL = sizeof fatal / sizeof *fatal };

/* Signal handlers know no arguments, and there is one of each in a process. */
static int watching;
static bool leaving, registered;
static struct sigaction before[FATAL];

static void end_alone(int signal_number) {
  (void)signal_number;
  _exit(HC_FAILED); /* the launcher may end the others */
}

/* MPI may not find its way out: without memory, or where the heap broke with its lock held. Then this rank
 * leaves by itself. */
static void be_patient(void) {
  enum { PATIENCE = 10 }; /* s */
  signal(SIGALRM, end_alone);
  alarm(PATIENCE);
}

static void end_all(int exit_code) {
  leaving = true;
  be_patient();
  int started = 0, ended = 0;
  MPI_Initialized(&started);
  MPI_Finalized(&ended);
  if (started && !ended) MPI_Abort(MPI_COMM_WORLD, exit_code);
}

/* What was there before, MPI's own printing of the stack for instance. */
static void let_speak(const struct sigaction *action, int number, siginfo_t *facts, void *context) {
  if (action->sa_flags & SA_SIGINFO)
    action->sa_sigaction(number, facts, context);
  else if (action->sa_handler != SIG_DFL && action->sa_handler != SIG_IGN)
    action->sa_handler(number);
}

static void crash(int number, siginfo_t *facts, void *context) {
  be_patient();
  for (int k = 0; k < FATAL; k++) signal(fatal[k], SIG_DFL); /* a second one ends this process */
  for (int k = 0; k < FATAL; k++)
    if (fatal[k] == number) let_speak(&before[k], number, facts, context);
  end_all(128 + number); /* as shells count signals */
  _exit(128 + number);
}

/* A library that exits ends this process alone. */
static void leave_others(int exit_code, void *unused) {
  (void)unused;
  if (watching > 0 && !leaving) end_all(exit_code ? exit_code : HC_FAILED);
}

/* Nobody mends an abort; else a handler for once only reports. */
static bool is_free(int number, const struct sigaction *action) {
  return number == SIGABRT || action->sa_flags & SA_RESETHAND ||
         (!(action->sa_flags & SA_SIGINFO) && action->sa_handler == SIG_DFL);
}

static bool is_ours(const struct sigaction *action) {
  return action->sa_flags & SA_SIGINFO && action->sa_sigaction == crash;
}

void hc_ending_watch(void) {
  int processes = 0;
  CHECK_MPI(MPI_Comm_size(MPI_COMM_WORLD, &processes));
  if (watching++ > 0 || processes == 1) return;
  hc_check_set_leave(end_all);
  if (!registered) registered = on_exit(leave_others, NULL) == 0;
  struct sigaction action;
  memset(&action, 0, sizeof action);
  action.sa_sigaction = crash;
  action.sa_flags = SA_SIGINFO; /* blocks the signal meanwhile: others' handlers may raise it again */
  sigemptyset(&action.sa_mask);
  for (int k = 0; k < FATAL; k++)
    if (sigaction(fatal[k], NULL, &before[k]) == 0 && is_free(fatal[k], &before[k]))
      sigaction(fatal[k], &action, NULL);
}

void hc_ending_unwatch(void) {
  if (--watching > 0) return;
  hc_check_set_leave(NULL);
  for (int k = 0; k < FATAL; k++) {
    struct sigaction now;
    if (sigaction(fatal[k], NULL, &now) == 0 && is_ours(&now)) sigaction(fatal[k], &before[k], NULL);
  }
}
