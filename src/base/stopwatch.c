#include "stopwatch.h"

const char *hc_stage_name(hc_stage stage) {
  static const char *const names[HC_STAGE_COUNT] = {
      [HC_STAGE_SETUP] = "setup",   [HC_STAGE_BALANCE] = "balance",   [HC_STAGE_MIGRATE] = "migrate",
      [HC_STAGE_SORT] = "sort",     [HC_STAGE_HALO] = "halo",         [HC_STAGE_BIRTHS] = "births",
      [HC_STAGE_LISTS] = "lists",   [HC_STAGE_DENSITY] = "density",   [HC_STAGE_DIVERGENCE] = "divergence",
      [HC_STAGE_FORCES] = "forces", [HC_STAGE_PRESSURE] = "pressure", [HC_STAGE_STEPS] = "steps",
      [HC_STAGE_MOVE] = "move",     [HC_STAGE_OUTPUT] = "output"};
  return names[stage];
}
