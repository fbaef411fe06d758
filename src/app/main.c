/* The program: finds the command and hands over. */
#include "base/check.h"
#include "comm/comm.h"
#include "commands.h"
#include "halocline/version.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const hc_command commands[] = {
    {"run", "SCENE.yaml", "Simulates a scene; under mpirun on all ranks together.", "osnfqRw", 1, true,
     hc_command_run},
    {"check", "SCENE.yaml", "Reads and validates a scene, counts its particles, runs nothing.", "srj", 1,
     false, hc_command_check},
    {"info", "FILE", "Tells what a snapshot, checkpoint or rest state holds.", "j", 1, false,
     hc_command_info},
    {"diff", "A B",
     "Compares two snapshots or checkpoints particle by particle: 0 same, 1 different, 2 cannot compare.",
     "tj", 2, false, hc_command_diff},
    {"rest", "SCENE.yaml", "Lets a fluid come to rest and saves it, for scenes to fill shapes with.", "osfq",
     1, true, hc_command_rest},
    {"keys", "", "Lists every scene key: type, unit, default, range, one sentence.", "m", 0, false,
     hc_command_keys},
};
enum { COMMAND_COUNT = sizeof commands / sizeof *commands };

static void usage(FILE *out) {
  fprintf(out, "Usage: [mpirun -n N] halocline COMMAND [ARGUMENTS]\n\nCommands:\n");
  for (int k = 0; k < COMMAND_COUNT; k++)
    fprintf(out, "  %-6s %-11s %s\n", commands[k].name, commands[k].usage, commands[k].summary);
  fprintf(
      out,
      "\nhalocline COMMAND --help tells more, halocline --version the version.\n"
      "Exit codes: 0 done, 1 the simulation failed, 2 bad usage or input, 3 an output or checkpoint could "
      "not be written or read, 75 stopped early: run again with --restart.\n");
}

/* A standard stream that the caller closed would give its number to the next file opened, and that file what
 * is meant for the stream. The other way round, neither can be used: output is an error again. */
static void hold_streams(void) {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; stream++)
    if (fcntl(stream, F_GETFD) < 0)
      if (open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream) _exit(HC_IO_FAILED);
}

int main(int argc, char **argv) {
  hold_streams();
  signal(SIGXFSZ, SIG_IGN); /* a file size limit becomes a write error */
  const int rank = hc_comm_launched_rank();
  hc_check_set_rank(rank);
  const bool loud = rank == 0;
  const char *name = argc > 1 ? argv[1] : "";
  if (strcmp(name, "--help") == 0 || strcmp(name, "-?") == 0 || strcmp(name, "--version") == 0) {
    if (loud && strcmp(name, "--version") == 0)
      printf("halocline %s\n", hc_version());
    else if (loud)
      usage(stdout);
    return fflush(stdout) == 0 ? 0 : HC_IO_FAILED;
  }
  for (int k = 0; k < COMMAND_COUNT; k++) {
    if (strcmp(name, commands[k].name) != 0) continue;
    hc_options options;
    const int code = hc_options_parse(&commands[k], argc - 1, argv + 1, loud, &options);
    if (code >= 0) return code;
    return loud || commands[k].parallel ? commands[k].run(&options) : HC_OK;
  }
  if (loud && argc > 1) fprintf(stderr, "halocline: error: there is no command '%s'\n", name);
  if (loud) usage(stderr);
  return loud ? HC_BAD_INPUT : HC_OK; /* see hc_options_parse */
}
