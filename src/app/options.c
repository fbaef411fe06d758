#include "options.h"

#include "halocline/error.h"

#include <argp.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const struct argp_option all_options[] = {
    {"output", 'o', "DIR", 0, "where the run's files go (default: out/NAME), or the rest state: a file", 0},
    {"set", 's', "KEY=VALUE", 0, "a scene key's value in place of the file's; may be repeated", 0},
    {"steps", 'n', "N", 0, "stop after step N", 0},
    {"restart", 'R', "FILE", OPTION_ARG_OPTIONAL,
     "go on from the newest valid checkpoint of the output directory, or from FILE; without any checkpoint "
     "start over",
     0},
    {"walltime", 'w', "SECONDS", 0,
     "before that much time has passed, write a checkpoint and stop with exit code 75", 0},
    {"force", 'f', 0, 0, "overwrite the run that the directory holds, or the file", 0},
    {"quiet", 'q', 0, 0, "no progress line", 0},
    {"ranks", 'r', "N", 0, "for how many ranks to estimate", 0},
    {"tolerance", 't', "T", 0, "how much may differ: T metres of a position, T m/s of a velocity, ...", 0},
    {"json", 'j', 0, 0, "report as one JSON object", 0},
    {"solver", 'm', "NAME", 0, "only keys that matter to this solver", 0},
    {"help", '?', 0, 0, "tell this", -1},
};
enum { OPTION_COUNT = sizeof all_options / sizeof *all_options };

typedef struct parsing {
  const hc_command *command;
  hc_options *options;
} parsing;

static int64_t whole_number(struct argp_state *state, const char *option, const char *text, int64_t least) {
  char *end;
  errno = 0;
  const long long value = strtoll(text, &end, 10);
  if (errno || end == text || *end || value < least)
    argp_error(state, "--%s must be a whole number of at least %lld, got '%s'", option, (long long)least,
               text);
  return value;
}

static double number(struct argp_state *state, const char *option, const char *text) {
  char *end;
  const double value = strtod(text, &end);
  if (end == text || *end || !(value >= 0.0) || isinf(value))
    argp_error(state, "--%s must be a number of at least 0, got '%s'", option, text);
  return value;
}

static error_t take(int key, char *text, struct argp_state *state) {
  const parsing *parsing = state->input;
  hc_options *options = parsing->options;
  switch (key) {
  case 'o':
    options->output = text;
    break;
  case 's':
    if (options->override_count == HC_MAX_OVERRIDES) {
      argp_error(state, "at most %d --set", HC_MAX_OVERRIDES);
      break;
    }
    options->overrides[options->override_count++] = text;
    break;
  case 'n':
    options->steps = whole_number(state, "steps", text, 0);
    break;
  case 'r':
    options->ranks = whole_number(state, "ranks", text, 1);
    break;
  case 't':
    options->tolerance = number(state, "tolerance", text);
    break;
  case 'R':
    options->restart = true;
    options->restart_file = text;
    break;
  case 'w':
    options->walltime = number(state, "walltime", text);
    if (options->walltime == 0.0) argp_error(state, "--walltime must be above 0, got '%s'", text);
    break;
  case 'm':
    options->solver = text;
    break;
  case 'f':
    options->force = true;
    break;
  case 'q':
    options->quiet = true;
    break;
  case 'j':
    options->json = true;
    break;
  case '?':
    argp_state_help(state, stdout, ARGP_HELP_STD_HELP & ~(unsigned)ARGP_HELP_EXIT_OK);
    exit(fflush(stdout) == 0 ? HC_OK : HC_IO_FAILED);
  case ARGP_KEY_ARG:
    if (options->file_count == parsing->command->files) {
      argp_error(state, "'%s' is one argument too many", text);
      break;
    }
    options->files[options->file_count++] = text;
    break;
  case ARGP_KEY_END:
    if (options->restart && options->force)
      argp_error(state, "--force starts over, --restart goes on: they exclude each other");
    if (options->file_count < parsing->command->files)
      argp_error(state, "%s needs %s", parsing->command->name, parsing->command->usage);
    break;
  default:
    return ARGP_ERR_UNKNOWN;
  }
  return 0;
}

/* Leads a stream to nowhere; returns a copy of it, for `restore`. */
static int silence(int stream) {
  const int copy = dup(stream), nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) {
    dup2(nowhere, stream);
    close(nowhere);
  }
  return copy;
}

static void restore(int stream, int copy) {
  if (copy < 0) return;
  dup2(copy, stream);
  close(copy);
}

int hc_options_parse(const hc_command *command, int argc, char **argv, bool loud, hc_options *options) {
  *options = (hc_options){.steps = -1, .ranks = 1};
  struct argp_option own[OPTION_COUNT + 1];
  int count = 0;
  for (int k = 0; k < OPTION_COUNT; k++)
    if (all_options[k].key == '?' || strchr(command->options, all_options[k].key))
      own[count++] = all_options[k];
  memset(&own[count], 0, sizeof own[count]);

  parsing parsing = {command, options};
  const struct argp argp = {own, take, command->usage, command->summary, NULL, NULL, NULL};
  char name[64];
  snprintf(name, sizeof name, "halocline %s", command->name);
  argv[0] = name;
  if (loud) {
    argp_err_exit_status = 2;
    return argp_parse(&argp, argc, argv, ARGP_NO_HELP, NULL, &parsing) == 0
               ? -1
               : 2; /* exits by itself after messages */
  }
  argp_err_exit_status = 0;
  const int out = silence(STDOUT_FILENO), err = silence(STDERR_FILENO);
  const bool good = argp_parse(&argp, argc, argv, ARGP_NO_HELP, NULL, &parsing) == 0;
  restore(STDOUT_FILENO, out);
  restore(STDERR_FILENO, err);
  return good ? -1 : 0;
}
