#include "params.h"

#include "base/check.h"
#include "scene.h"

#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const hc_choice viscosity_models[] = {{"none", HC_VISCOSITY_NONE},
                                             {"xsph", HC_VISCOSITY_XSPH},
                                             {"artificial", HC_VISCOSITY_ARTIFICIAL},
                                             {"laminar", HC_VISCOSITY_LAMINAR},
                                             {"smagorinsky", HC_VISCOSITY_SMAGORINSKY},
                                             {NULL, 0}};
static const hc_choice flow_types[] = {{"none", HC_FLOW_NONE},
                                       {"taylor_green", HC_FLOW_TAYLOR_GREEN},
                                       {"standing_wave", HC_FLOW_STANDING_WAVE},
                                       {NULL, 0}};
static const hc_choice boundary_methods[] = {{"akinci2012", HC_BOUNDARY_AKINCI2012},
                                             {"ihmsen2010", HC_BOUNDARY_IHMSEN2010},
                                             {"becker2009", HC_BOUNDARY_BECKER2009},
                                             {"harada2007", HC_BOUNDARY_HARADA2007},
                                             {NULL, 0}};
static const hc_choice tension_models[] = {
    {"none", HC_TENSION_NONE}, {"becker2007", HC_TENSION_BECKER2007}, {NULL, 0}};
static const hc_choice friction_laws[] = {{"none", HC_SCENE_FRICTION_NONE},
                                          {"no_slip", HC_SCENE_FRICTION_NO_SLIP},
                                          {"smooth", HC_SCENE_FRICTION_SMOOTH},
                                          {"rough", HC_SCENE_FRICTION_ROUGH},
                                          {NULL, 0}};
static const hc_choice wall_densities[] = {
    {"sum", HC_WALL_DENSITY_SUM}, {"squared", HC_WALL_DENSITY_SQUARED}, {NULL, 0}};
static const hc_choice density_corrections[] = {
    {"none", HC_CORRECTION_NONE}, {"shepard", HC_CORRECTION_SHEPARD}, {NULL, 0}};
static const hc_choice pressure_solves[] = {
    {"fast", HC_PRESSURE_SOLVE_FAST}, {"paper", HC_PRESSURE_SOLVE_PAPER}, {NULL, 0}};
static const hc_choice insides[] = {{"fluid", HC_INSIDE_FLUID}, {"solid", HC_INSIDE_SOLID}, {NULL, 0}};
static const hc_choice faces[] = {{"-x", HC_FACE_MINUS_X}, {"+x", HC_FACE_PLUS_X},  {"-y", HC_FACE_MINUS_Y},
                                  {"+y", HC_FACE_PLUS_Y},  {"-z", HC_FACE_MINUS_Z}, {"+z", HC_FACE_PLUS_Z},
                                  {"base", HC_FACE_BASE},  {"top", HC_FACE_TOP},    {NULL, 0}};
static const hc_choice directions[] = {{"none", 0},
                                       {"-x", HC_FACE_MINUS_X},
                                       {"+x", HC_FACE_PLUS_X},
                                       {"-y", HC_FACE_MINUS_Y},
                                       {"+y", HC_FACE_PLUS_Y},
                                       {"-z", HC_FACE_MINUS_Z},
                                       {"+z", HC_FACE_PLUS_Z},
                                       {NULL, 0}};
static const hc_choice solver_methods[] = {
    {"dfsph", HC_SOLVER_DFSPH}, {"pcisph", HC_SOLVER_PCISPH}, {"wcsph", HC_SOLVER_WCSPH}, {NULL, 0}};
static const hc_choice motion_types[] = {{"none", HC_WALL_STANDS},
                                         {"constant", HC_WALL_CONSTANT},
                                         {"cosine", HC_WALL_COSINE},
                                         {"table", HC_WALL_TABLE},
                                         {NULL, 0}};
static const hc_choice locks[] = {
    {"x", HC_LOCKED_X},         {"y", HC_LOCKED_Y},     {"z", HC_LOCKED_Z}, {"roll", HC_LOCKED_ROLL},
    {"pitch", HC_LOCKED_PITCH}, {"yaw", HC_LOCKED_YAW}, {NULL, 0}};
static const hc_choice force_frames[] = {{"world", HC_FORCE_WORLD}, {"body", HC_FORCE_BODY}, {NULL, 0}};
static const hc_choice mooring_types[] = {
    {"line", HC_MOORING_LINE}, {"spring", HC_MOORING_SPRING}, {NULL, 0}};
static const hc_choice interpolations[] = {
    {"linear", HC_INTERPOLATION_LINEAR}, {"smooth", HC_INTERPOLATION_SMOOTH}, {NULL, 0}};
static const hc_choice leavings[] = {{"error", HC_LEAVING_ERROR}, {"remove", HC_LEAVING_REMOVE}, {NULL, 0}};
static const hc_choice time_controls[] = {{"constant", HC_TIME_CONSTANT},     {"cfl", HC_TIME_CFL},
                                          {"adaptive", HC_TIME_ADAPTIVE},     {"global", HC_TIME_GLOBAL},
                                          {"individual", HC_TIME_INDIVIDUAL}, {NULL, 0}};
static const hc_choice individual_steps[] = {
    {"power_of_two", HC_STEPS_POWER_OF_TWO}, {"raw", HC_STEPS_RAW}, {NULL, 0}};
static const hc_choice decompositions[] = {
    {"slabs", HC_DECOMPOSITION_SLABS}, {"metis", HC_DECOMPOSITION_METIS}, {NULL, 0}};
static const hc_choice rebalances[] = {
    {"none", HC_REBALANCE_NONE}, {"slabs", HC_REBALANCE_SLABS}, {"metis", HC_REBALANCE_METIS}, {NULL, 0}};

static const hc_choice gauge_types[] = {{"height", HC_GAUGE_HEIGHT},
                                        {"front", HC_GAUGE_FRONT},
                                        {"pressure", HC_GAUGE_PRESSURE},
                                        {"flow", HC_GAUGE_FLOW},
                                        {"force", HC_GAUGE_FORCE},
                                        {"energy", HC_GAUGE_ENERGY},
                                        {"volume", HC_GAUGE_VOLUME},
                                        {"density", HC_GAUGE_DENSITY},
                                        {"body", HC_GAUGE_BODY},
                                        {"mooring", HC_GAUGE_MOORING},
                                        {NULL, 0}};

static const char *const gauge_names[] = {[HC_GAUGE_HEIGHT] = "height",
                                          [HC_GAUGE_FRONT] = "front",
                                          [HC_GAUGE_PRESSURE] = "pressure",
                                          [HC_GAUGE_FLOW] = "flow",
                                          [HC_GAUGE_FORCE] = "force",
                                          [HC_GAUGE_ENERGY] = "energy",
                                          [HC_GAUGE_VOLUME] = "volume",
                                          [HC_GAUGE_DENSITY] = "density",
                                          [HC_GAUGE_BODY] = "body",
                                          [HC_GAUGE_MOORING] = "mooring",
                                          NULL};
enum {
  HEIGHT = 1 << HC_GAUGE_HEIGHT,
  FRONT = 1 << HC_GAUGE_FRONT,
  PRESSURE = 1 << HC_GAUGE_PRESSURE,
  FLOW = 1 << HC_GAUGE_FLOW,
  FORCE = 1 << HC_GAUGE_FORCE,
  ENERGY = 1 << HC_GAUGE_ENERGY,
  VOLUME = 1 << HC_GAUGE_VOLUME,
  DENSITY = 1 << HC_GAUGE_DENSITY,
  BODY = 1 << HC_GAUGE_BODY,
  MOORING = 1 << HC_GAUGE_MOORING
};

static const char *const wall_forms[] = {[HC_FORM_BOX] = "box",
                                         [HC_FORM_CYLINDER] = "cylinder",
                                         [HC_FORM_SPHERE] = "sphere",
                                         [HC_FORM_MESH] = "mesh",
                                         [HC_FORM_REVOLUTION] = "revolution",
                                         [HC_FORM_PLANE] = "plane",
                                         NULL};
static const char *const block_forms[] = {
    [HC_FORM_BOX] = "box",   [HC_FORM_CYLINDER] = "cylinder",     [HC_FORM_SPHERE] = "sphere",
    [HC_FORM_MESH] = "mesh", [HC_FORM_REVOLUTION] = "revolution", NULL};
static const char *const emitter_forms[] = {
    [HC_EMITTER_DISC] = "disc", [HC_EMITTER_RECTANGLE] = "rectangle", NULL};
enum { DISC = 1 << HC_EMITTER_DISC, RECTANGLE = 1 << HC_EMITTER_RECTANGLE };
enum {
  BOX = 1 << HC_FORM_BOX,
  CYLINDER = 1 << HC_FORM_CYLINDER,
  SPHERE = 1 << HC_FORM_SPHERE,
  MESH = 1 << HC_FORM_MESH,
  REVOLUTION = 1 << HC_FORM_REVOLUTION,
  PLANE = 1 << HC_FORM_PLANE
};

#define ANY                                                                                                  \
  { -INFINITY, INFINITY, false }
#define POSITIVE                                                                                             \
  { 0.0, INFINITY, true }
#define AT_LEAST(low)                                                                                        \
  { low, INFINITY, false }
#define WITHIN(low, high)                                                                                    \
  { low, high, false }
#define ABOVE_WITHIN(low, high)                                                                              \
  { low, high, true }
#define WITH(chooser_, value) .chooser = chooser_, .chosen = 1u << (value)
#define AMONG(chooser_, bits) .chooser = chooser_, .chosen = (bits)
#define UNLESS(chooser_, value) .chooser = chooser_, .chosen = ~(1u << (value))
#define HC_PARAM(path_, kind_, member_, unit_, fallback_, range_, sentence_, ...)                            \
  {.path = path_,                                                                                            \
   .kind = HC_PARAM_##kind_,                                                                                 \
   .offset = BASE + offsetof(OWNER, member_),                                                                \
   .size = sizeof(((OWNER *)0)->member_),                                                                    \
   .unit = unit_,                                                                                            \
   .fallback = fallback_,                                                                                    \
   .range = range_,                                                                                          \
   .sentence = sentence_,                                                                                    \
   __VA_ARGS__},
#define TABLE(rows) .params = rows, .count = sizeof(rows) / sizeof((rows)[0]), .size = sizeof(OWNER)

/* Where the struct that the rows are of lies in the table's. */
#define BASE 0

#define OWNER hc_block
#define HC_BLOCK_PARAMS
static const hc_param block_rows[] = {
#include "params.def"
};
static const hc_param_table block_table = {TABLE(block_rows), .variants = block_forms,
                                           .variant_offset = offsetof(hc_block, form)};
#undef HC_BLOCK_PARAMS
#undef OWNER

#define OWNER hc_scene_emitter
#define HC_EMITTER_PARAMS
static const hc_param emitter_rows[] = {
#include "params.def"
};
static const hc_param_table emitter_table = {TABLE(emitter_rows), .variants = emitter_forms,
                                             .variant_offset = offsetof(hc_scene_emitter, form)};
#undef HC_EMITTER_PARAMS
#undef OWNER

#define OWNER hc_motion_point
#define HC_MOTION_PARAMS
static const hc_param motion_rows[] = {
#include "params.def"
};
static const hc_param_table motion_table = {TABLE(motion_rows)};
#undef HC_MOTION_PARAMS
#undef OWNER

#define OWNER hc_wall
#define HC_WALL_PARAMS
static const hc_param wall_rows[] = {
#include "params.def"
};
static const hc_param_table wall_table = {TABLE(wall_rows), .variants = wall_forms,
                                          .variant_offset = offsetof(hc_wall, form)};
#undef HC_WALL_PARAMS
#undef OWNER

#define OWNER hc_scene_force
#define HC_FORCE_PARAMS
static const hc_param force_rows[] = {
#include "params.def"
};
static const hc_param_table force_table = {TABLE(force_rows)};
#undef HC_FORCE_PARAMS
#undef OWNER

#define OWNER hc_scene_mooring
#define HC_MOORING_PARAMS
static const hc_param mooring_rows[] = {
#include "params.def"
};
static const hc_param_table mooring_table = {TABLE(mooring_rows)};
#undef HC_MOORING_PARAMS
#undef OWNER

/* A body's rows are those of its surface, and its own. */
static const hc_param body_rows[] = {
#undef BASE
#define BASE offsetof(hc_scene_body, surface)
#define OWNER hc_wall
#define HC_SURFACE_PARAMS
#include "params.def"
#undef HC_SURFACE_PARAMS
#undef OWNER
#undef BASE
#define BASE 0
#define OWNER hc_scene_body
#define HC_BODY_PARAMS
#include "params.def"
#undef HC_BODY_PARAMS
};
static const hc_param_table body_table = {TABLE(body_rows), .variants = block_forms,
                                          .variant_offset = offsetof(hc_scene_body, surface.form)};
#undef OWNER

#define OWNER hc_scene_absorption
#define HC_ABSORPTION_PARAMS
static const hc_param absorption_rows[] = {
#include "params.def"
};
static const hc_param_table absorption_table = {TABLE(absorption_rows)};
#undef HC_ABSORPTION_PARAMS
#undef OWNER

#define OWNER hc_scene_gauge
#define HC_GAUGE_PARAMS
static const hc_param gauge_rows[] = {
#include "params.def"
};
static const hc_param_table gauge_table = {TABLE(gauge_rows), .variants = gauge_names, .chosen_by_type = true,
                                           .variant_offset = offsetof(hc_scene_gauge, type)};
#undef HC_GAUGE_PARAMS
#undef OWNER

#define OWNER hc_scene
#define HC_SCENE_PARAMS
static const hc_param scene_rows[] = {
#include "params.def"
};
const hc_param_table hc_params_scene = {TABLE(scene_rows)};
#undef HC_SCENE_PARAMS
#undef OWNER

_Static_assert(sizeof(((hc_scene *)0)->output.snapshot_fields[0]) == HC_PARAM_NAME_SIZE, "size of a name");
_Static_assert(sizeof(hc_flow_type) == sizeof(int), "choices are stored as int");

int hc_params_length(const hc_param *param) {
  switch (param->kind) {
  case HC_PARAM_BOOL:
    return (int)(param->size / sizeof(bool));
  case HC_PARAM_INT64:
    return (int)(param->size / sizeof(int64_t));
  case HC_PARAM_NUMBER:
    return (int)(param->size / sizeof(double));
  default:
    return 1;
  }
}

bool hc_params_applies(const hc_param *param, int variant) {
  return param->only == 0 || (variant >= 0 && (param->only >> variant & 1));
}

bool hc_params_required(const hc_param *param) {
  return !param->fallback && !param->fallback_note;
}

const hc_param *hc_params_find(const hc_param_table *table, const char *path) {
  for (int k = 0; k < table->count; k++)
    if (strcmp(table->params[k].path, path) == 0) return &table->params[k];
  return NULL;
}

bool hc_params_is_map(const hc_param_table *table, const char *path) {
  const size_t length = strlen(path);
  for (int k = 0; k < table->count; k++) {
    const char *known = table->params[k].path;
    if (strncmp(known, path, length) == 0 && known[length] == '.') return true;
  }
  return false;
}

static int chooser_value(const hc_param *chooser, const void *owner) {
  const void *member = (const char *)owner + chooser->offset;
  if (chooser->kind == HC_PARAM_CHOICE) return *(const int *)member;
  HC_CHECK(chooser->kind == HC_PARAM_BOOL, "key '%s' of kind %d chooses nothing", chooser->path,
           chooser->kind);
  for (int k = 0; k < hc_params_length(chooser); k++)
    if (((const bool *)member)[k]) return true;
  return false;
}

static const hc_param *chooser_of(const hc_param_table *table, const hc_param *param) {
  const hc_param *chooser = hc_params_find(table, param->chooser);
  HC_CHECK(chooser, "'%s', which decides on '%s', is not in the parameter table", param->chooser,
           param->path);
  return chooser;
}

bool hc_params_used(const hc_param_table *table, const hc_param *param, const void *owner) {
  if (!param->chooser) return true;
  const hc_param *const chooser = chooser_of(table, param);
  return hc_params_used(table, chooser, owner) && param->chosen >> chooser_value(chooser, owner) & 1;
}

const char *hc_params_choice_name(const hc_choice *choices, int value) {
  while (choices->name && choices->value != value) choices++;
  HC_CHECK(choices->name, "no choice has the value %d", value);
  return choices->name;
}

void hc_params_chooser_text(const hc_param_table *table, const hc_param *param, const void *owner, char *text,
                            size_t size) {
  const hc_param *chooser = chooser_of(table, param);
  if (!hc_params_used(table, chooser, owner)) {
    hc_params_chooser_text(table, chooser, owner, text, size);
    return;
  }
  const int value = chooser_value(chooser, owner);
  snprintf(text, size, "%s is %s", chooser->path,
           chooser->choices ? hc_params_choice_name(chooser->choices, value)
           : value          ? "true"
                            : "false");
}

void hc_params_number_text(double value, char text[static HC_PARAM_NUMBER_TEXT]) {
  /* The "C" locale is a constant of the C library: making it neither fails nor costs. */
  const locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  const locale_t before = uselocale(plain);
  for (int digits = 15; digits <= 17; digits++) {
    snprintf(text, HC_PARAM_NUMBER_TEXT, "%.*g", digits, value);
    if (strtod(text, NULL) == value) break;
  }
  uselocale(before);
  freelocale(plain);
}

void hc_params_range_text(const hc_param *param, char *text, size_t size) {
  const hc_range range = param->range;
  char low[HC_PARAM_NUMBER_TEXT], high[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(range.low, low);
  hc_params_number_text(range.high, high);
  text[0] = '\0';
  if (isfinite(range.high))
    snprintf(text, size, "in %c%s, %s]", range.above_low ? '(' : '[', low, high);
  else if (isfinite(range.low))
    snprintf(text, size, "%s %s", range.above_low ? ">" : ">=", low);
}

void hc_params_choices_text(const hc_choice *choices, char *text, size_t size) {
  size_t used = 0;
  text[0] = '\0';
  for (const hc_choice *choice = choices; choice->name && used < size; choice++)
    used += (size_t)snprintf(text + used, size - used, "%s%s", choice == choices ? "" : ", ", choice->name);
}

/* --- halocline keys --- */

enum { COLUMNS = 5, COLUMN_TEXT = 128 };

typedef struct row {
  char text[COLUMNS][COLUMN_TEXT];
  const char *sentence;
} row;

static void type_text(const hc_param *param, char *text, size_t size) {
  static const char *const names[] = {
      [HC_PARAM_BOOL] = "bool",         [HC_PARAM_INT] = "integer",     [HC_PARAM_INT64] = "integer",
      [HC_PARAM_NUMBER] = "number",     [HC_PARAM_TEXT] = "text",       [HC_PARAM_CHOICE] = "choice",
      [HC_PARAM_FLAGS] = "choice list", [HC_PARAM_PAIRS] = "pair list", [HC_PARAM_NAMES] = "name list",
      [HC_PARAM_LIST] = "map list"};
  const int length = hc_params_length(param);
  if (length > 1)
    snprintf(text, size, "%s[%d]", names[param->kind], length);
  else
    snprintf(text, size, "%s", names[param->kind]);
}

static void constraint_text(const hc_param *param, char *text, size_t size) {
  char range[2 * HC_PARAM_NUMBER_TEXT + 8];
  hc_params_range_text(param, range, sizeof range);
  if (param->choices)
    hc_params_choices_text(param->choices, text, size);
  else if (param->range_note)
    snprintf(text, size, "%s", param->range_note);
  else if (param->zero_word)
    snprintf(text, size, "%s or %s", range, param->zero_word);
  else if (param->kind == HC_PARAM_BOOL)
    snprintf(text, size, "true, false");
  else
    snprintf(text, size, "%s", range[0] ? range : "-");
}

static row make_row(const hc_param *param, const char *prefix) {
  row made = {.sentence = param->sentence};
  snprintf(made.text[0], COLUMN_TEXT, "%s%s", prefix, param->path);
  type_text(param, made.text[1], COLUMN_TEXT);
  snprintf(made.text[2], COLUMN_TEXT, "%s", param->unit[0] ? param->unit : "-");
  const char *fallback = param->fallback_note ? param->fallback_note : param->fallback;
  snprintf(made.text[3], COLUMN_TEXT, "%s", fallback ? fallback : "required");
  constraint_text(param, made.text[4], COLUMN_TEXT);
  return made;
}

static const char solver_key[] = "solver.method";

/* Is a key for some of these methods, whatever else decides on it? */
static bool of_solvers(const hc_param_table *table, const hc_param *param, unsigned solvers) {
  if (!param->chooser) return true;
  if (strcmp(param->chooser, solver_key) == 0) return param->chosen & solvers;
  return of_solvers(table, chooser_of(table, param), solvers);
}

/* Calls for every visible row of the table and of the tables of its lists: once to measure, once to print.
 * `solvers` has a bit for each method of interest. */
static void visit(const hc_param_table *table, const char *prefix, unsigned solvers, int width[COLUMNS],
                  FILE *out) {
  for (int k = 0; k < table->count; k++) {
    const hc_param *param = &table->params[k];
    if (param->hidden || !of_solvers(table, param, solvers)) continue;
    const row made = make_row(param, prefix);
    for (int c = 0; c < COLUMNS; c++) {
      const int length = (int)strlen(made.text[c]);
      if (!out && width[c] < length) width[c] = length;
      if (out) fprintf(out, "%-*s  ", width[c], made.text[c]);
    }
    if (out) fprintf(out, "%s\n", made.sentence);
    if (param->kind == HC_PARAM_LIST) {
      char inner[COLUMN_TEXT];
      snprintf(inner, sizeof inner, "%s%s[].", prefix, param->path);
      visit(param->items, inner, solvers, width, out);
    }
  }
}

hc_status hc_params_print(FILE *out, const char *solver, hc_error *error) {
  const hc_param *method = hc_params_find(&hc_params_scene, solver_key);
  HC_CHECK(method && method->choices, "the parameter table has no %s", solver_key);
  unsigned solvers = solver ? 0 : ~0u;
  for (const hc_choice *choice = method->choices; choice->name; choice++)
    if (solver && strcmp(solver, choice->name) == 0) solvers = 1u << choice->value;
  if (!solvers) {
    char names[COLUMN_TEXT];
    hc_params_choices_text(method->choices, names, sizeof names);
    return hc_error_set(error, HC_BAD_INPUT, "unknown solver '%s'; known: %s", solver, names);
  }
  static const row head = {{"key", "type", "unit", "default", "range"}, "meaning"};
  int width[COLUMNS];
  for (int c = 0; c < COLUMNS; c++) width[c] = (int)strlen(head.text[c]);
  visit(&hc_params_scene, "", solvers, width, NULL);
  for (int c = 0; c < COLUMNS; c++) fprintf(out, "%-*s  ", width[c], head.text[c]);
  fprintf(out, "%s\n", head.sentence);
  visit(&hc_params_scene, "", solvers, width, out);
  return HC_OK;
}
