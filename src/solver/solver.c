#include "solver.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

bool hc_solver_works_with(const hc_solver_ops *solver, const char *control) {
  if (!solver->controls) return true;
  for (const char *const *name = solver->controls; *name; name++)
    if (strcmp(*name, control) == 0) return true;
  return false;
}

void hc_solver_tell_caps(const hc_solver_caps *caps, char *text, size_t size) {
  snprintf(text, size,
           "iteration caps hit: density solver %" PRId64 ", divergence solver %" PRId64 " of %" PRId64
           " steps",
           caps->density, caps->divergence, caps->steps);
}
