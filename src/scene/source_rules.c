#include "source_rules.h"

static bool is_zero(const double v[3]) {
  return v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0;
}

static void complain(const hc_given *given, const char *path, hc_complaints *complaints, const char *what) {
  hc_complaints_add(complaints, hc_given_place_of(given, path), "%s%s must %s", given->prefix, path, what);
}

/* Of an item of a list as a whole. */
static void complain_of_item(const hc_given *given, hc_complaints *complaints, const char *what) {
  hc_complaints_add(complaints, given->place, "%.*s must %s",
                    (int)(given->prefix[0] ? __builtin_strlen(given->prefix) - 1 : 0), given->prefix, what);
}

/* `stop` 0 is never. */
static void check_times(const hc_given *given, const char *start_path, const char *stop_path, double start,
                        double stop, hc_complaints *complaints) {
  if (hc_given_is_bad(given, start_path) || hc_given_is_bad(given, stop_path) || stop == 0.0 || stop > start)
    return;
  char start_text[HC_PARAM_NUMBER_TEXT], stop_text[HC_PARAM_NUMBER_TEXT];
  hc_params_number_text(start, start_text);
  hc_params_number_text(stop, stop_text);
  hc_complaints_add(complaints, hc_given_place_of(given, stop_path), "%s%s must be > %s, not %s <= %s",
                    given->prefix, stop_path, start_path, stop_text, start_text);
}

static void check_turn(const hc_wall_motion *motion, const hc_given *given, hc_complaints *complaints) {
  if (!hc_given_is_bad(given, "motion.axis") && is_zero(motion->axis))
    complain(given, "motion.axis", complaints, "not be zero, not [0, 0, 0]");
  if (!hc_given_has(given, "motion.center") && !hc_given_is_bad(given, "motion.center"))
    hc_complaints_add(complaints, given->place,
                      "missing key '%smotion.center', required of a wall that turns", given->prefix);
}

static void check_cosine(const hc_wall_motion *motion, const hc_given *given, hc_complaints *complaints) {
  static const char *const paths[] = {"motion.amplitude", "motion.speed", "motion.angle",
                                      "motion.angular_velocity", "motion.direction"};
  for (int k = 0; k < 5; k++)
    if (hc_given_is_bad(given, paths[k])) return;
  if (!hc_given_has(given, "motion.frequency") && !hc_given_is_bad(given, "motion.frequency"))
    hc_complaints_add(complaints, given->place,
                      "missing key '%smotion.frequency', required with motion.type "
                      "cosine",
                      given->prefix);
  const bool shifts = motion->amplitude > 0.0 || motion->speed > 0.0,
             turns = motion->angle > 0.0 || motion->angular_velocity != 0.0;
  if (motion->amplitude > 0.0 && motion->speed > 0.0)
    complain(given, "motion.speed", complaints,
             "not be given beside motion.amplitude: one follows from the other");
  if (motion->angle > 0.0 && motion->angular_velocity != 0.0)
    complain(given, "motion.angular_velocity", complaints,
             "not be given beside motion.angle: one follows from the other");
  if (shifts && is_zero(motion->direction))
    complain(given, "motion.direction", complaints,
             "not be zero with an amplitude or a speed, not [0, 0, 0]");
  if (!shifts && !turns)
    complain(given, "motion.type", complaints,
             "have one of amplitude, speed, angle, angular_velocity above 0 with it: else the wall stands");
  if (turns) check_turn(motion, given, complaints);
}

static bool table_turns(const hc_wall_motion *motion) {
  for (int k = 0; k < motion->point_count; k++)
    if (motion->points[k].angle != 0.0) return true;
  return false;
}

static void check_table(const hc_wall_motion *motion, const hc_given *given, hc_complaints *complaints) {
  const hc_given_value *points = hc_given_value_of(given, "motion.points");
  if (hc_given_is_bad(given, "motion.file") || points->bad) return;
  if ((motion->point_count > 0) == (motion->file[0] != '\0')) {
    complain(given, "motion.points", complaints,
             motion->file[0] ? "not be given beside motion.file" : "have a row, or motion.file name a table");
    return;
  }
  for (int k = 0; k < points->item_count; k++) {
    const hc_given *item = &points->items[k];
    if (item->bad || hc_given_is_bad(item, "time")) return;
    if (k == 0 || motion->points[k].time > motion->points[k - 1].time) continue;
    char now[HC_PARAM_NUMBER_TEXT], before[HC_PARAM_NUMBER_TEXT];
    hc_params_number_text(motion->points[k].time, now);
    hc_params_number_text(motion->points[k - 1].time, before);
    hc_complaints_add(complaints, hc_given_place_of(item, "time"),
                      "%stime must be > the row's before it, not %s <= %s", item->prefix, now, before);
  }
  if (table_turns(motion)) check_turn(motion, given, complaints);
}

void hc_source_rules_loaded(const hc_wall *wall, const hc_given *given, hc_complaints *complaints) {
  if (hc_given_has(given, "motion.axis") || table_turns(&wall->motion))
    check_turn(&wall->motion, given, complaints);
}

void hc_source_rules_motion(const hc_wall *wall, const hc_given *given, hc_complaints *complaints) {
  const hc_wall_motion *motion = &wall->motion;
  if (hc_given_is_bad(given, "motion.type")) return;
  if (motion->type != HC_WALL_TABLE && motion->point_count > 0)
    complain(given, "motion.points", complaints, "not be given: they are for motion.type table");
  if (motion->type == HC_WALL_STANDS) return;
  check_times(given, "motion.start", "motion.stop", motion->start, motion->stop, complaints);
  if (motion->type == HC_WALL_COSINE) check_cosine(motion, given, complaints);
  if (motion->type == HC_WALL_TABLE) check_table(motion, given, complaints);
  if (motion->type != HC_WALL_CONSTANT || hc_given_is_bad(given, "motion.velocity") ||
      hc_given_is_bad(given, "motion.angular_velocity"))
    return;
  if (is_zero(motion->velocity) && motion->angular_velocity == 0.0)
    complain(given, "motion.type", complaints,
             "have a velocity or an angular_velocity with it: else the wall stands");
  if (motion->angular_velocity != 0.0) check_turn(motion, given, complaints);
}

void hc_source_rules_body(const hc_scene_body *body, const hc_given *given, hc_complaints *complaints) {
  const hc_given_value *const forces = hc_given_value_of(given, "forces");
  for (int k = 0; k < forces->item_count; k++)
    if (!forces->items[k].bad)
      check_times(&forces->items[k], "start", "stop", body->forces[k].start, body->forces[k].stop,
                  complaints);
  const double *const gyration = body->gyration;
  const int given_radii = (gyration[0] > 0.0) + (gyration[1] > 0.0) + (gyration[2] > 0.0);
  if (!hc_given_is_bad(given, "gyration") && given_radii % 3 != 0)
    complain(given, "gyration", complaints, "have three radii > 0, or none");
  if (hc_given_is_bad(given, "density") || hc_given_is_bad(given, "mass") ||
      hc_given_has(given, "density") != hc_given_has(given, "mass"))
    return;
  if (hc_given_has(given, "mass"))
    complain(given, "mass", complaints, "not be given beside density: one follows from the other");
  else
    complain_of_item(given, complaints, "have a density or a mass");
}

void hc_source_rules_emitter(const hc_scene_emitter *emitter, const hc_given *given,
                             hc_complaints *complaints) {
  const bool disc = emitter->form == HC_EMITTER_DISC;
  const char *direction = disc ? "disc.direction" : "rectangle.direction";
  if (hc_given_has(given, direction) && !hc_given_is_bad(given, direction) && is_zero(emitter->direction))
    complain(given, direction, complaints, "not be zero, not [0, 0, 0]");
  check_times(given, "start", "stop", emitter->start, emitter->stop, complaints);
  if (hc_given_is_bad(given, "speed") || hc_given_is_bad(given, "rate") ||
      (emitter->speed > 0.0) != (emitter->rate > 0.0))
    return;
  if (emitter->speed > 0.0)
    complain(given, "rate", complaints, "not be given beside speed: one follows from the other");
  else
    complain_of_item(given, complaints, "have a speed or a rate");
}
