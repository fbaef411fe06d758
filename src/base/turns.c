#include "turns.h"

#include <math.h>

/* t is reduced to a quarter turn, where the series needs ten terms. */
double hc_turns_sine(double t) {
  const double turn = t - rint(t); /* in [-1/2, 1/2] */
  const double quarter = turn > 0.25 ? 0.5 - turn : turn < -0.25 ? -0.5 - turn : turn;
  const double angle = 2 * 3.14159265358979323846 * quarter;
  double series = 1;
  for (int k = 10; k >= 1; k--) series = 1 - series * angle * angle / (2 * k * (2 * k + 1));
  return angle * series;
}

double hc_turns_cosine(double t) {
  return hc_turns_sine(t - rint(t) + 0.25);
}
