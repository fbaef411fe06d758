#include "logarithm.h"

#include <math.h>

/* x = m 2^k with m near 1, and ln m = 2 artanh((m - 1)/(m + 1)). */
double hc_logarithm(double x) {
  enum { TERMS = 12 };
  int exponent;
  double m = frexp(x, &exponent);
  if (m < 0.70710678118654752) {
    m *= 2.0;
    exponent--;
  }
  const double s = (m - 1.0) / (m + 1.0), square = s * s;
  double series = 0.0;
  for (int k = TERMS; k >= 0; k--) series = series * square + 1.0 / (2 * k + 1);
  return 2.0 * s * series + exponent * 0.693147180559945309;
}
