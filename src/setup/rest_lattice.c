#include "rest_lattice.h"

#include "base/check.h"
#include "base/turns.h"
#include "sph/kernel.h"

static const double sigma = 8 / 3.14159265358979323846;

/* W h^3, and dW/dq h^3 */
static double kernel(double q) {
  return sigma * hc_kernel_shape(q);
}
static double kernel_slope(double q) {
  return sigma * q * hc_kernel_slope_over_q(q);
}

/* Integral of W h^3 over a plane at distance z, in units of h^2: 2 pi times that of W q dq from z to 1. */
static double plane_integral(double z) {
  enum { STEPS = 2000 };
  const double step = (1 - z) / STEPS;
  double sum = 0;
  for (int k = 0; k < STEPS; k++) {
    const double q = z + (k + 0.5) * step;
    sum += kernel(q) * q * step;
  }
  return 2 * 3.14159265358979323846 * sum;
}

/* Sum of W h^3 over a plane of the lattice that lies `layer` spacings away. */
static double plane_sum(double spacing_over_h, double layer) {
  const int reach = (int)(1 / spacing_over_h) + 1;
  double sum = 0;
  for (int j = -reach; j <= reach; j++)
    for (int i = -reach; i <= reach; i++) sum += kernel(spacing_over_h * sqrt(i * i + j * j + layer * layer));
  return sum;
}

/* Sum over the planes `from` to the reach of the kernel. */
static double half_sum(double spacing_over_h, int from) {
  HC_CHECK(spacing_over_h >= 1.0 / 64 && spacing_over_h < 1,
           "spacing must be from 1/64 to below 1 support radius, got %g", spacing_over_h);
  const int reach = (int)(1 / spacing_over_h) + 1;
  double sum = 0;
  for (int layer = reach; layer >= from; layer--) sum += plane_sum(spacing_over_h, layer);
  return sum;
}

double hc_setup_rest_lattice_sum(double spacing_over_h) {
  return half_sum(spacing_over_h, 0) + half_sum(spacing_over_h, 1);
}

double hc_setup_wall_factor(double spacing_over_h) {
  const double half = half_sum(spacing_over_h, 0), all = hc_setup_rest_lattice_sum(spacing_over_h);
  return (1 - half / all) * plane_sum(spacing_over_h, 0) / plane_sum(spacing_over_h, 1);
}

double hc_setup_contact_limit(double spacing_over_h, double factor) {
  return factor * plane_sum(spacing_over_h, 0.5) / plane_sum(spacing_over_h, 0);
}

double hc_setup_flat_wall(double spacing_over_h, double factor) {
  return factor * plane_sum(spacing_over_h, 1) / plane_sum(spacing_over_h, 0);
}

double hc_setup_start_limit(double spacing_over_h, double factor) {
  return 1.05 *
         fmax(3 * hc_setup_flat_wall(spacing_over_h, factor), hc_setup_contact_limit(spacing_over_h, factor));
}

double hc_setup_wall_share(double spacing_over_h) {
  const double all = hc_setup_rest_lattice_sum(spacing_over_h);
  return 1 - half_sum(spacing_over_h, 1) / all;
}

double hc_setup_rest_lattice_gradient(double spacing_over_h) {
  const int reach = (int)(1 / spacing_over_h) + 1;
  double sum = 0;
  for (int k = -reach; k <= reach; k++)
    for (int j = -reach; j <= reach; j++)
      for (int i = -reach; i <= reach; i++) {
        const double slope = kernel_slope(spacing_over_h * sqrt(i * i + j * j + k * k));
        sum += slope * slope;
      }
  return sum;
}

/* |sum sin(k.x) grad W|^2 of a wave, its numbers in turns a spacing. */
static double wave_square(double spacing_over_h, const double turns[3]) {
  const int reach = (int)(1 / spacing_over_h) + 1;
  double sum[3] = {0, 0, 0};
  for (int k = -reach; k <= reach; k++)
    for (int j = -reach; j <= reach; j++)
      for (int i = -reach; i <= reach; i++) {
        const double q = spacing_over_h * sqrt(i * i + j * j + k * k);
        if (q == 0 || q >= 1) continue;
        const double wave = hc_turns_sine(i * turns[0] + j * turns[1] + k * turns[2]) * kernel_slope(q) / q;
        sum[0] += wave * spacing_over_h * i;
        sum[1] += wave * spacing_over_h * j;
        sum[2] += wave * spacing_over_h * k;
      }
  return sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2];
}

double hc_setup_rest_lattice_eigenvalue(double spacing_over_h) {
  enum { STEPS = 12 }; /* to half a turn a spacing */
  double largest = 0;
  for (int i = 0; i <= STEPS; i++) /* the lattice looks the same along all axes */
    for (int j = 0; j <= i; j++)
      for (int k = 0; k <= j; k++) {
        const double turns[3] = {0.5 * i / STEPS, 0.5 * j / STEPS, 0.5 * k / STEPS};
        largest = fmax(largest, wave_square(spacing_over_h, turns));
      }
  return largest / hc_setup_rest_lattice_gradient(spacing_over_h);
}

double hc_setup_half_space(double spacing_over_h, double distance) {
  double sum = 0;
  for (double z = distance; z < 1; z += spacing_over_h) sum += plane_integral(z);
  return sum / (spacing_over_h * spacing_over_h);
}
