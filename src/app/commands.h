/* The program's commands; each returns the exit code. */
#ifndef HC_COMMANDS_H
#define HC_COMMANDS_H

#include "options.h"
#include "scene/reader.h"

int hc_command_run(const hc_options *options);
int hc_command_check(const hc_options *options);
int hc_command_info(const hc_options *options);
int hc_command_diff(const hc_options *options);
int hc_command_keys(const hc_options *options);

/* Names that output.snapshots.fields may hold. `names` has room for HC_FIELD_COUNT. */
hc_scene_limits hc_command_scene_limits(const char **names);

/* Says "halocline: error: TEXT" on stderr and returns the status as exit code. */
int hc_command_fail(const hc_error *error);

/* Says "halocline: warning: TEXT" on stderr for each. */
void hc_command_warn(const hc_warnings *warnings);

#endif
