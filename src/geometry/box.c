#include "box.h"

bool hc_box_contains(const double min[3], const double max[3], double margin, const double x[3]) {
  for (int a = 0; a < 3; a++)
    if (!(x[a] >= min[a] - margin && x[a] <= max[a] + margin)) return false;
  return true;
}

bool hc_box_inside(const double a_min[3], const double a_max[3], const double b_min[3], const double b_max[3],
                   double margin) {
  return hc_box_contains(b_min, b_max, margin, a_min) && hc_box_contains(b_min, b_max, margin, a_max);
}

bool hc_box_overlaps(const double a_min[3], const double a_max[3], const double b_min[3],
                     const double b_max[3], double margin) {
  for (int a = 0; a < 3; a++) {
    const double low = a_min[a] > b_min[a] ? a_min[a] : b_min[a];
    const double high = a_max[a] < b_max[a] ? a_max[a] : b_max[a];
    if (!(high - low > margin)) return false;
  }
  return true;
}
