#include "motion.h"

#include "base/turns.h"

#include <math.h>
#include <string.h>

static const double TWO_PI = 2 * 3.14159265358979323846;

/* The four numbers that move: three shifts and the turns. */
enum { NUMBERS = 4 };

typedef struct moment {
  double value[NUMBERS], rate[NUMBERS];
} moment;

static void numbers_of(const hc_motion_row *row, double numbers[NUMBERS]) {
  memcpy(numbers, row->shift, 3 * sizeof *numbers);
  numbers[3] = row->turns;
}

/* The slope at a row of a smooth table: that of the parabola through it and its two neighbours; 0 at the
 * ends, where it comes to rest. */
static void slopes_at(const hc_motion *motion, int row, double slope[NUMBERS]) {
  memset(slope, 0, NUMBERS * sizeof *slope);
  if (row == 0 || row == motion->row_count - 1) return;
  const hc_motion_row *at = &motion->rows[row];
  double before[NUMBERS], here[NUMBERS], behind[NUMBERS];
  numbers_of(at - 1, before);
  numbers_of(at, here);
  numbers_of(at + 1, behind);
  const double left = at->time - at[-1].time, right = at[1].time - at->time;
  for (int k = 0; k < NUMBERS; k++)
    slope[k] = ((here[k] - before[k]) / left * right + (behind[k] - here[k]) / right * left) / (left + right);
}

/* Between two rows: straight, or the cubic through both with their slopes. */
static moment between(const hc_motion *motion, int row, double time) {
  const hc_motion_row *from = &motion->rows[row];
  const double length = from[1].time - from->time, s = (time - from->time) / length;
  double start[NUMBERS], end[NUMBERS], slope[2][NUMBERS];
  numbers_of(from, start);
  numbers_of(from + 1, end);
  slopes_at(motion, row, slope[0]);
  slopes_at(motion, row + 1, slope[1]);
  moment found;
  for (int k = 0; k < NUMBERS; k++) {
    const double rise = end[k] - start[k];
    if (!motion->smooth) {
      found.value[k] = start[k] + s * rise;
      found.rate[k] = rise / length;
      continue;
    }
    const double m0 = slope[0][k] * length, m1 = slope[1][k] * length;
    const double square = 3 * rise - 2 * m0 - m1, cube = m0 + m1 - 2 * rise;
    found.value[k] = start[k] + s * (m0 + s * (square + s * cube));
    found.rate[k] = (m0 + s * (2 * square + 3 * s * cube)) / length;
  }
  return found;
}

static moment from_table(const hc_motion *motion, double time) {
  moment found;
  memset(&found, 0, sizeof found);
  const hc_motion_row *rows = motion->rows;
  const int last = motion->row_count - 1;
  if (time < rows[0].time || time >= rows[last].time) {
    numbers_of(time < rows[0].time ? &rows[0] : &rows[last], found.value);
    return found;
  }
  int low = 0, high = last; /* rows[low].time <= time < rows[high].time */
  while (high - low > 1) {
    const int middle = low + (high - low) / 2;
    if (rows[middle].time <= time)
      low = middle;
    else
      high = middle;
  }
  return between(motion, low, time);
}

/* At a time since the start. */
static moment moment_at(const hc_motion *motion, double time) {
  moment found;
  memset(&found, 0, sizeof found);
  if (motion->law == HC_MOTION_TABLE) return from_table(motion, time);
  if (motion->law == HC_MOTION_STILL || motion->law == HC_MOTION_BODY) return found;
  double factor = time, rate = 1;
  if (motion->law == HC_MOTION_COSINE) {
    const double turns = motion->frequency * time + motion->phase;
    factor = hc_turns_cosine(turns) - hc_turns_cosine(motion->phase);
    rate = -TWO_PI * motion->frequency * hc_turns_sine(turns);
  }
  const double size[NUMBERS] = {motion->shift[0], motion->shift[1], motion->shift[2], motion->turns};
  for (int k = 0; k < NUMBERS; k++) {
    found.value[k] = factor * size[k];
    found.rate[k] = rate * size[k];
  }
  return found;
}

/* Rodrigues' formula, less the identity. */
static void turn_about(const double u[3], double turns, double turn[3][3]) {
  const double sine = hc_turns_sine(turns), rest = 1 - hc_turns_cosine(turns);
  const double across[3][3] = {{0, -u[2], u[1]}, {u[2], 0, -u[0]}, {-u[1], u[0], 0}};
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) turn[a][b] = rest * (u[a] * u[b] - (a == b)) + sine * across[a][b];
}

hc_pose hc_motion_pose(const hc_motion *motion, double time) {
  const bool moving = time >= motion->start && time < motion->stop;
  const double since = fmin(fmax(time, motion->start), motion->stop) - motion->start;
  const moment now = moment_at(motion, since);
  hc_pose pose;
  memset(&pose, 0, sizeof pose);
  memcpy(pose.shift, now.value, sizeof pose.shift);
  if (now.value[3] != 0) turn_about(motion->axis, now.value[3], pose.turn);
  for (int a = 0; moving && a < 3; a++) {
    pose.velocity[a] = now.rate[a];
    pose.spin[a] = TWO_PI * now.rate[3] * motion->axis[a];
  }
  return pose;
}

static double length(const double v[3]) {
  return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

double hc_pose_speed(const hc_pose *pose, double reach) {
  return length(pose->velocity) + length(pose->spin) * reach;
}

bool hc_motion_turns(const hc_motion *motion) {
  if (motion->law != HC_MOTION_TABLE) return motion->turns != 0;
  for (int k = 0; k < motion->row_count; k++)
    if (motion->rows[k].turns != 0) return true;
  return false;
}

static void include(const double shift[3], double low[3], double high[3]) {
  for (int a = 0; a < 3; a++) {
    low[a] = fmin(low[a], shift[a]);
    high[a] = fmax(high[a], shift[a]);
  }
}

void hc_motion_range(const hc_motion *motion, double until, double low[3], double high[3]) {
  for (int a = 0; a < 3; a++) low[a] = high[a] = 0;
  if (motion->law == HC_MOTION_CONSTANT) {
    const hc_pose end = hc_motion_pose(motion, until);
    include(end.shift, low, high);
  }
  for (int side = -1; motion->law == HC_MOTION_COSINE && side <= 1; side += 2) {
    double end[3];
    for (int a = 0; a < 3; a++) end[a] = (side - hc_turns_cosine(motion->phase)) * motion->shift[a];
    include(end, low, high);
  }
  for (int k = 0; motion->law == HC_MOTION_TABLE && k < motion->row_count; k++)
    include(motion->rows[k].shift, low, high);
}
