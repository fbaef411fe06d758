#include "rest_state.h"

#include "base/memory.h"

void hc_rest_state_free(hc_rest_state *state) {
  if (state) hc_free(state->position);
  hc_free(state);
}
