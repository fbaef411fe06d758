/* The command line: what each command takes, parsed with argp. */
#ifndef HC_OPTIONS_H
#define HC_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

enum { HC_MAX_OVERRIDES = 256 };

typedef struct hc_options {
  const char *files[2]; /* SCENE, FILE, or A and B */
  int file_count;
  const char *overrides[HC_MAX_OVERRIDES]; /* --set key=value */
  int override_count;
  const char *output;       /* -o; null: out/NAME */
  int64_t steps;            /* --steps; negative: to the end time */
  int64_t ranks;            /* --ranks */
  double tolerance;         /* --tolerance */
  double walltime;          /* --walltime, s; 0: none */
  bool restart;             /* --restart */
  const char *restart_file; /* --restart=FILE; null: the newest */
  const char *solver;       /* --solver */
  bool force, quiet, json;
} hc_options;

typedef struct hc_command {
  const char *name, *usage, *summary;    /* usage: what follows the name */
  const char *options;                   /* the letters of the options it takes, see options.c */
  int files;                             /* how many it needs */
  bool parallel;                         /* all ranks work; else only the first */
  int (*run)(const hc_options *options); /* returns the exit code */
} hc_command;

/* Parses the words behind a command's name. Returns -1 to go on; else the program must end with the exit code
 * returned (or has): 0 after --help, 2 after an error. A process that is not `loud` says nothing and ends
 * with 0: the launcher passes on the code of the one that is, and would end it before its message if another
 * failed first. */
int hc_options_parse(const hc_command *command, int argc, char **argv, bool loud, hc_options *options);

#endif
