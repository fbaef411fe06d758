#include "mesh_formats.h"

#include <math.h>

hc_status hc_mesh_read_point(const char *path, const hc_lines *lines, char **at, double x[3],
                             hc_error *error) {
  for (int a = 0; a < 3; a++) {
    const char *const word = hc_lines_word(at);
    if (!word || !hc_lines_number(lines, word, &x[a]))
      return hc_error_set(error, HC_BAD_INPUT, "%s:%d: a vertex must have three numbers, not '%.80s'", path,
                          lines->number, word ? word : "");
  }
  return HC_OK;
}

double hc_mesh_decimal(float value) {
  static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10,
                                  1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21};
  const double size = fabs((double)value);
  if (!(size >= 1e-12 && size < 1e9)) return value;
  int whole = 0; /* digits before the point; below 0: zeros behind it */
  while (whole < 10 && size >= powers[whole]) whole++;
  while (whole > -12 && whole <= 0 && size < 1 / powers[1 - whole]) whole--;
  for (int digits = 6; digits <= 9; digits++) {
    const int places = digits - whole;
    if (places < 0 || places > 21) continue;
    const double rounded = rint(value * powers[places]) / powers[places];
    if ((float)rounded == value) return rounded;
  }
  return value;
}
