/* The calls of METIS. */
#include "graph.h"

#include "base/memory.h"

#include <signal.h>
#include <string.h>

/* A part may exceed the mean by this much; of two divisions within it the one that cuts less is taken. */
static const double ALLOWED_IMBALANCE = 1.03;

enum {
  ALLOWED_PER_MILLE = 20,     /* what METIS is asked for */
  BOTH_WAYS_UP_TO = 200000,   /* vertices: beyond, the recursive way takes too long beside the k-way one */
  TRIES = 2,                  /* of which METIS keeps the best, */
  SEVERAL_TRIES_UP_TO = 20000 /* for graphs of at most so many vertices */
};

typedef int (*metis_call)(idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, real_t *,
                          real_t *, idx_t *, idx_t *, idx_t *);

/* One division. METIS catches SIGTERM and SIGABRT while it works, as signs of its own errors: one that means
 * the program waits until it has done. */
static bool divide(metis_call call, const hc_graph *graph, int parts, idx_t *part) {
  idx_t options[METIS_NOPTIONS], count = graph->count, constraints = 1, part_count = parts, cut = 0;
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = 1;
  options[METIS_OPTION_UFACTOR] = ALLOWED_PER_MILLE;
  options[METIS_OPTION_NCUTS] = count <= SEVERAL_TRIES_UP_TO ? TRIES : 1;
  sigset_t termination, before;
  sigemptyset(&termination);
  sigaddset(&termination, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &termination, &before);
  const int status = call(&count, &constraints, graph->start, graph->adjacent, graph->vertex_weight, NULL,
                          graph->edge_weight, &part_count, NULL, NULL, options, &cut, part);
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  return status == METIS_OK;
}

static double imbalance_of(const hc_graph *graph, int parts, const idx_t *part) {
  double *weight = hc_alloc_zero((size_t)parts, sizeof *weight), total = 0.0, largest = 0.0;
  for (idx_t k = 0; k < graph->count; k++) {
    weight[part[k]] += graph->vertex_weight[k];
    total += graph->vertex_weight[k];
  }
  for (int p = 0; p < parts; p++)
    if (weight[p] > largest) largest = weight[p];
  hc_free(weight);
  return total > 0.0 ? largest * parts / total : 1.0;
}

/* Is the division with this cut and imbalance the better one? */
static bool better(int64_t cut, double imbalance, int64_t than_cut, double than_imbalance) {
  const bool balanced = imbalance <= ALLOWED_IMBALANCE, other = than_imbalance <= ALLOWED_IMBALANCE;
  if (balanced != other) return balanced;
  return balanced ? cut < than_cut : imbalance < than_imbalance;
}

/* Gives a vertex's bricks to a part. */
static void give(const hc_graph *graph, idx_t vertex, int32_t to, int32_t *part) {
  for (int32_t k = graph->first[vertex]; k < graph->first[vertex + 1]; k++) part[k] = to;
}

const char *hc_graph_divide(const hc_graph *graph, int parts, int32_t *part) {
  static const struct {
    const char *name;
    metis_call call;
  } ways[] = {{"k-way", METIS_PartGraphKway}, {"recursive", METIS_PartGraphRecursive}};
  if (parts == 1 || graph->count <= parts) { /* nothing to divide, which METIS would not bear */
    for (idx_t v = 0; v < graph->count; v++) give(graph, v, parts == 1 ? 0 : (int32_t)v, part);
    return "trivial";
  }
  idx_t *found = hc_alloc((size_t)graph->count, sizeof *found);
  const size_t bricks = (size_t)graph->first[graph->count];
  int32_t *candidate = hc_alloc(bricks, sizeof *candidate);
  const char *best = NULL;
  int64_t best_cut = 0;
  double best_imbalance = 0.0;
  for (int way = 0; way < (graph->count <= BOTH_WAYS_UP_TO ? 2 : 1); way++) {
    if (!divide(ways[way].call, graph, parts, found)) continue;
    for (idx_t v = 0; v < graph->count; v++) give(graph, v, (int32_t)found[v], candidate);
    const int64_t cut = hc_graph_edge_cut(graph, candidate);
    const double imbalance = imbalance_of(graph, parts, found);
    if (!best || better(cut, imbalance, best_cut, best_imbalance)) {
      best = ways[way].name;
      best_cut = cut;
      best_imbalance = imbalance;
      memcpy(part, candidate, bricks * sizeof *part);
    }
  }
  hc_free(candidate);
  hc_free(found);
  return best;
}
