/* The parameter table: what every scene key is called, holds and means (rows: params.def).
 *
 * Reader, writer and `halocline keys` walk these tables; there is no second list of keys. */
#ifndef HC_PARAMS_H
#define HC_PARAMS_H

#include "halocline/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef enum hc_param_kind {
  HC_PARAM_BOOL,   /* bool or bool[N] */
  HC_PARAM_INT,    /* int */
  HC_PARAM_INT64,  /* int64_t or int64_t[N] */
  HC_PARAM_NUMBER, /* double or double[N], finite */
  HC_PARAM_TEXT,   /* char[N] */
  HC_PARAM_CHOICE, /* an enumeration */
  HC_PARAM_FLAGS,  /* unsigned: a list of choices, or-ed */
  HC_PARAM_PAIRS,  /* double (*)[2] and a count, allocated */
  HC_PARAM_NAMES,  /* char[][HC_PARAM_NAME_SIZE] and a count: names the caller knows (hc_scene_limits) */
  HC_PARAM_LIST,   /* pointer and count: maps, each read by the table `items` */
} hc_param_kind;

enum { HC_PARAM_NAME_SIZE = 32, HC_PARAM_PATH = 192 };

typedef struct hc_choice {
  const char *name; /* null ends the list */
  int value;
} hc_choice;

typedef struct hc_range {
  double low, high;
  bool above_low; /* low itself is outside */
} hc_range;

typedef struct hc_param_table hc_param_table;

typedef struct hc_param {
  const char *path; /* from the table's root, maps joined by dots */
  hc_param_kind kind;
  size_t offset, size; /* of the member in the table's struct */
  const char *unit;
  const char *fallback;      /* the default as YAML text, or null */
  const char *fallback_note; /* the default for people, where `fallback` is null or does not say it all */
  hc_range range;
  const char *range_note; /* a constraint checked in rules.c, shown instead of the range */
  const char *sentence;
  const hc_choice *choices; /* CHOICE, FLAGS */
  const char *zero_word;    /* NUMBER: the word that stands for zero */
  const hc_param_table *items;
  size_t count_offset; /* PAIRS, NAMES, LIST: of the int that counts */
  const char *chooser; /* path of the CHOICE or BOOL that decides whether this key is used; null: always */
  unsigned chosen;     /* bits 1 << value of the chooser with which it is; a BOOL is 1 if any component is */
  unsigned only;       /* bit k: the table's variant k has this key; 0: all have it */
  unsigned needed;     /* bit k: the table's variant k must be given it */
  bool shorter; /* NUMBER: the last component may be left away, and is no number until a rule fills it in */
  bool may_change; /* a run may go on from a checkpoint under another value */
  bool hidden;     /* a test hook: accepted, but not in `halocline keys` */
} hc_param;

struct hc_param_table {
  const hc_param *params;
  int count;
  size_t size; /* of the struct */
  /* Alternatives of which an item has exactly one, each a map of that name; null: none. */
  const char *const *variants;
  bool chosen_by_type; /* the variant is not the map that is there, but what the first key, a choice, says */
  size_t variant_offset; /* of the int that holds the variant's index */
};

extern const hc_param_table hc_params_scene;

/* Components: 1 for a scalar. */
int hc_params_length(const hc_param *param);

/* True for a key that items of this variant have; any have it where the table has no variants. */
bool hc_params_applies(const hc_param *param, int variant);

/* True for a key that must be given (in items of its variant). */
bool hc_params_required(const hc_param *param);

/* The row of `path`, or null. */
const hc_param *hc_params_find(const hc_param_table *table, const char *path);

/* True if `path` is a map that holds keys. */
bool hc_params_is_map(const hc_param_table *table, const char *path);

/* The constraint of a row's range, such as "> 0" or "in [0, 1]"; empty if there is none. */
void hc_params_range_text(const hc_param *param, char *text, size_t size);

/* True if the modes chosen in `owner` (a filled struct of the table) make use of a key of it. */
bool hc_params_used(const hc_param_table *table, const hc_param *param, const void *owner);

/* What such a key hangs on, for messages: "time_step.control is cfl". */
void hc_params_chooser_text(const hc_param_table *table, const hc_param *param, const void *owner, char *text,
                            size_t size);

/* The name of a value in a null-ended list of choices, which must have it. */
const char *hc_params_choice_name(const hc_choice *choices, int value);

/* The names of a null-ended list of choices: "a, b, c". */
void hc_params_choices_text(const hc_choice *choices, char *text, size_t size);

/* A number in the fewest digits that read back to the same double; the same in every locale. */
enum { HC_PARAM_NUMBER_TEXT = 32 };
void hc_params_number_text(double value, char text[static HC_PARAM_NUMBER_TEXT]);

/* Prints every key with type, unit, default, range and sentence; with `solver`, only keys that matter to that
 * method. Null prints all. HC_BAD_INPUT if no solver is called so. Local. */
hc_status hc_params_print(FILE *out, const char *solver, hc_error *error);

#endif
