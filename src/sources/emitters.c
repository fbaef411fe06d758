#include "emitters.h"

#include "arrivals.h"
#include "base/memory.h"
#include "particles/ids.h"

#include <math.h>
#include <string.h>

/* More samples than this make no layer. */
static const double MOST_SAMPLES = 0x1p24;

/* Lengths are decimal fractions. */
static const double TOLERANCE = 1e-6;

void hc_emitters_free(hc_emitters *emitters) {
  for (int k = 0; k < emitters->count; k++) hc_free(emitters->emitters[k].samples);
  hc_free(emitters->emitters);
  memset(emitters, 0, sizeof *emitters);
}

/* ---- the lattice ---- */

bool hc_emitter_sample_rectangle(hc_emitter *emitter) {
  double cells[2];
  for (int t = 0; t < 2; t++)
    cells[t] = floor((emitter->shape.high[t] - emitter->shape.low[t]) / emitter->spacing + TOLERANCE);
  emitter->sample_count = 0;
  if (!(cells[0] * cells[1] <= MOST_SAMPLES)) return false;
  const int64_t columns = (int64_t)cells[0], rows = (int64_t)cells[1];
  emitter->samples = hc_alloc((size_t)(columns * rows), sizeof *emitter->samples);
  for (int64_t row = 0; row < rows; row++)
    for (int64_t column = 0; column < columns; column++) {
      double *at = emitter->samples[emitter->sample_count++];
      at[0] = ((double)column - 0.5 * (double)(columns - 1)) * emitter->spacing;
      at[1] = ((double)row - 0.5 * (double)(rows - 1)) * emitter->spacing;
    }
  return true;
}

bool hc_emitter_sample_disc(hc_emitter *emitter, double radius) {
  const double half = ceil(radius / emitter->spacing), largest = radius * radius * (1.0 + TOLERANCE);
  emitter->sample_count = 0;
  if (!(4.0 * half * half <= MOST_SAMPLES)) return false;
  const int64_t end = (int64_t)half;
  emitter->samples = hc_alloc((size_t)(4 * end * end), sizeof *emitter->samples);
  for (int64_t row = -end; row < end; row++)
    for (int64_t column = -end; column < end; column++) {
      const double x = ((double)column + 0.5) * emitter->spacing, y = ((double)row + 0.5) * emitter->spacing;
      if (x * x + y * y > largest) continue;
      double *at = emitter->samples[emitter->sample_count++];
      at[0] = x;
      at[1] = y;
    }
  return true;
}

void hc_emitter_point(const hc_emitter *emitter, int64_t sample, double along, double x[3]) {
  const double *at = emitter->samples[sample];
  for (int a = 0; a < 3; a++)
    x[a] = emitter->shape.centre[a] + at[0] * emitter->shape.axes[0][a] + at[1] * emitter->shape.axes[1][a] +
           along * emitter->shape.axes[2][a];
}

/* ---- when ---- */

static double due_at(const hc_emitter *emitter, int64_t layer) {
  return emitter->start + (double)layer * emitter->spacing / emitter->speed;
}

static bool is_due(const hc_emitter *emitter, double time) {
  const double due = due_at(emitter, emitter->layers);
  return due <= time && due < emitter->stop && emitter->emitted < emitter->limit;
}

double hc_emitter_layers_until(const hc_emitter *emitter, double end) {
  return fmax(0.0, ceil((fmin(emitter->stop, end) - emitter->start) * emitter->speed / emitter->spacing));
}

double hc_emitter_most(const hc_emitter *emitter, double end) {
  return fmin(hc_emitter_layers_until(emitter, end) * (double)emitter->sample_count, (double)emitter->limit);
}

double hc_emitters_speed(const hc_emitters *emitters, double time, double ahead) {
  double largest = 0.0;
  for (int k = 0; k < emitters->count; k++)
    if (is_due(&emitters->emitters[k], time + ahead)) largest = fmax(largest, emitters->emitters[k].speed);
  return largest;
}

bool hc_emitters_due(const hc_emitters *emitters, double time) {
  for (int k = 0; k < emitters->count; k++)
    if (is_due(&emitters->emitters[k], time)) return true;
  return false;
}

void hc_emitters_register(hc_emitters *emitters, hc_state *state) {
  for (int k = 0; k < emitters->count; k++) {
    hc_emitter *emitter = &emitters->emitters[k];
    hc_state_add(state, HC_TYPE_i64, 1, &emitter->layers, "emitters.%d.layers", k);
    hc_state_add(state, HC_TYPE_i64, 1, &emitter->emitted, "emitters.%d.emitted", k);
    hc_state_add(state, HC_TYPE_i64, 1, &emitter->blocked, "emitters.%d.blocked", k);
  }
}

/* ---- release ---- */

/* One release: what all its layers share. */
typedef struct release {
  const hc_domain *domain;
  const hc_cells *cells;
  const hc_particles *fluid;
  hc_arrivals arrivals; /* of this rank */
  hc_vicinity vicinity;
} release;

/* What becomes of a sample on this rank. */
typedef enum verdict { ELSEWHERE, BLOCKED, FREE } verdict;

static verdict judge(release *r, const hc_emitter *emitter, int64_t sample, double along, int64_t x[3]) {
  const hc_frame *frame = r->domain->frame;
  double metres[3];
  int64_t cell[3];
  hc_emitter_point(emitter, sample, along, metres);
  for (int a = 0; a < 3; a++) {
    x[a] = hc_frame_wrap(frame, a, hc_frame_to_units(frame, a, metres[a]));
    cell[a] = hc_frame_cell(x[a]);
  }
  if (hc_domain_owner(r->domain, cell) != r->domain->comm->rank) return ELSEWHERE;
  return hc_arrivals_blocked(frame, r->cells, r->fluid, &r->vicinity, x, emitter->clearance) ? BLOCKED : FREE;
}

/* How many of the layer's free samples may come in: those up to the limit, in the order of the layer. Returns
 * the first sample that may not. Collective. */
static int64_t last_place(const release *r, const hc_emitter *emitter, const int64_t *free_samples) {
  int64_t *all = hc_alloc((size_t)emitter->sample_count, sizeof *all);
  memcpy(all, free_samples, (size_t)emitter->sample_count * sizeof *all);
  hc_comm_sum_i64(r->domain->comm, all, (int)emitter->sample_count);
  int64_t room = emitter->limit - emitter->emitted, end = 0;
  for (; end < emitter->sample_count && room > 0; end++) room -= all[end];
  hc_free(all);
  return end;
}

static void add(release *r, const hc_emitter *emitter, int64_t sample, const int64_t x[3]) {
  hc_arrival *const to = hc_arrivals_add(
      &r->arrivals,
      hc_id_make(HC_ID_FLUID, emitter->source, (uint64_t)(emitter->layers * emitter->sample_count + sample)),
      x);
  for (int a = 0; a < 3; a++) to->velocity[a] = emitter->speed * emitter->shape.axes[2][a];
}

/* Brings in the next layer of an emitter. Collective. */
static void release_layer(release *r, hc_emitter *emitter, double time) {
  const double along = emitter->speed * (time - due_at(emitter, emitter->layers));
  const size_t count = (size_t)emitter->sample_count;
  int64_t *free_samples = hc_alloc_zero(count, sizeof *free_samples);
  int64_t(*places)[3] = hc_alloc(count, sizeof *places);
  int64_t totals[2] = {0, 0}; /* free, blocked */
  for (int64_t k = 0; k < emitter->sample_count; k++) {
    const verdict verdict = judge(r, emitter, k, along, places[k]);
    free_samples[k] = verdict == FREE;
    totals[0] += verdict == FREE;
    totals[1] += verdict == BLOCKED;
  }
  hc_comm_sum_i64(r->domain->comm, totals, 2);
  const int64_t room = emitter->limit - emitter->emitted;
  const int64_t end = totals[0] > room ? last_place(r, emitter, free_samples) : emitter->sample_count;
  for (int64_t k = 0; k < end; k++)
    if (free_samples[k]) add(r, emitter, k, places[k]);
  emitter->emitted += totals[0] < room ? totals[0] : room;
  emitter->blocked += totals[1];
  emitter->layers++;
  hc_free(places);
  hc_free(free_samples);
}

int64_t hc_emitters_release(hc_emitters *emitters, const hc_domain *domain, const hc_cells *cells,
                            hc_particles *fluid, double time) {
  if (!hc_emitters_due(emitters, time)) return 0;
  release r = {.domain = domain, .cells = cells, .fluid = fluid};
  int64_t added = 0;
  for (int k = 0; k < emitters->count; k++) {
    hc_emitter *emitter = &emitters->emitters[k];
    const int64_t before = emitter->emitted;
    while (is_due(emitter, time)) release_layer(&r, emitter, time);
    added += emitter->emitted - before;
  }
  if (added > 0) hc_arrivals_append(&r.arrivals, fluid);
  hc_arrivals_free(&r.arrivals);
  return added;
}
