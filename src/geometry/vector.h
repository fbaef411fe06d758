/* Small vectors in double precision, and directions. Local; + - * / and square roots only. */
#ifndef HC_VECTOR_H
#define HC_VECTOR_H

#include <math.h>

static inline double hc_vector_dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void hc_vector_cross(const double a[3], const double b[3], double product[3]) {
  product[0] = a[1] * b[2] - a[2] * b[1];
  product[1] = a[2] * b[0] - a[0] * b[2];
  product[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void hc_vector_minus(const double a[3], const double b[3], double difference[3]) {
  for (int k = 0; k < 3; k++) difference[k] = a[k] - b[k];
}

static inline double hc_vector_length(const double a[3]) {
  return sqrt(hc_vector_dot(a, a));
}

/* To unit length; a vector of no length stays 0. */
static inline void hc_vector_normalize(double a[3]) {
  const double length = hc_vector_length(a);
  for (int k = 0; k < 3; k++) a[k] = length > 0 ? a[k] / length : 0;
}

/* The direction of any vector, of unit length: scaled first, for squares of extreme components would over- or
 * underflow. A vector of no length stays 0; `unit` may be `a`. */
static inline void hc_vector_direction(const double a[3], double unit[3]) {
  const double largest = fmax(fabs(a[0]), fmax(fabs(a[1]), fabs(a[2])));
  for (int k = 0; k < 3; k++) unit[k] = largest > 0 ? a[k] / largest : 0;
  hc_vector_normalize(unit);
}

/* The angle between two vectors, rad, to 1e-7: the same on every machine, which acos is not (Abramowitz and
 * Stegun 4.4.49). */
static inline double hc_vector_angle(const double a[3], const double b[3]) {
  static const double series[] = {1,
                                  -0.3333314528,
                                  0.1999355085,
                                  -0.1420889944,
                                  0.1065626393,
                                  -0.0752896400,
                                  0.0429096138,
                                  -0.0161657367,
                                  0.0028662257};
  static const double right = 1.57079632679489661923;
  double product[3], sum = 0;
  hc_vector_cross(a, b, product);
  const double y = hc_vector_length(product), x = hc_vector_dot(a, b), along = fabs(x);
  if (y == 0) return x < 0 ? 2 * right : 0;
  const double ratio = y < along ? y / along : along / y, square = ratio * ratio;
  for (int k = 8; k >= 0; k--) sum = sum * square + series[k];
  const double small = ratio * sum, acute = y < along ? small : right - small;
  return x < 0 ? 2 * right - acute : acute;
}

#endif
