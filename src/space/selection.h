/* Which own particles a sweep or a neighbour list is for: all, those at the border, the interior, those that
 * are due. A selection is rows [begin, end); row r is particle index[r], ascending, or r itself where there
 * is no index. Rows of a list are those of the selection it was built for, of which sweeps may take a part;
 * or any particles of it, where the list is of all. A row's sum does not depend on which other rows there
 * are. */
#ifndef HC_SELECTION_H
#define HC_SELECTION_H

#include "particles/particles.h"

typedef struct hc_selection {
  const int32_t *index; /* null: a row is its particle; the caller's */
  int32_t begin, end;
  bool of_all; /* with an index: a list of all particles has the rows, each at its particle's number */
} hc_selection;

/* The particle of a row. */
static inline int32_t hc_selected(hc_selection selection, int32_t row) {
  return selection.index ? selection.index[row] : row;
}

/* Where a list has that row. */
static inline int32_t hc_row_of(hc_selection selection, int32_t row) {
  return selection.of_all ? selection.index[row] : row;
}

static inline hc_selection hc_select_range(int32_t begin, int32_t end) {
  return (hc_selection){NULL, begin, end, false};
}
static inline hc_selection hc_select_all(const hc_particles *particles) {
  return hc_select_range(0, particles->own);
}

/* The first row whose particle is no border particle. */
static inline int32_t hc_selection_interior_begin(hc_selection selection, const hc_particles *particles) {
  int32_t low = selection.begin, high = selection.end;
  while (low < high) {
    const int32_t middle = low + (high - low) / 2;
    if (hc_selected(selection, middle) < particles->border)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/* The parts of a selection that partners have copies of, and that none has. */
static inline hc_selection hc_select_border(hc_selection selection, const hc_particles *particles) {
  selection.end = hc_selection_interior_begin(selection, particles);
  return selection;
}
static inline hc_selection hc_select_interior(hc_selection selection, const hc_particles *particles) {
  selection.begin = hc_selection_interior_begin(selection, particles);
  return selection;
}

#endif
