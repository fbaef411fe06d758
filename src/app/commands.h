/* The program's commands; each returns the exit code. */
#ifndef HC_COMMANDS_H
#define HC_COMMANDS_H

#include "halocline/error.h"
#include "options.h"

int hc_command_run(const hc_options *options);
int hc_command_check(const hc_options *options);
int hc_command_info(const hc_options *options);
int hc_command_diff(const hc_options *options);
int hc_command_rest(const hc_options *options);
int hc_command_keys(const hc_options *options);

/* Says "halocline: error: TEXT" on stderr and returns the status as exit code. */
int hc_command_fail(const hc_error *error);

/* Standard output, written out: a full disk must not look like success. Returns the exit code. */
int hc_command_finish_output(void);

#endif
