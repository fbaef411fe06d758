/* The calls of METIS. */
#include "graph.h"

#include "base/memory.h"

#include <signal.h>
#include <stdlib.h>
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

/* One division, into parts of these shares, or equal ones. METIS catches SIGTERM and SIGABRT while it works,
 * as signs of its own errors: one that means the program waits until it has done. */
static bool divide(metis_call call, const hc_graph *graph, int parts, real_t *shares, int per_mille,
                   idx_t *part) {
  idx_t options[METIS_NOPTIONS], count = graph->count, constraints = 1, part_count = parts, cut = 0;
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = 1;
  options[METIS_OPTION_UFACTOR] = per_mille;
  options[METIS_OPTION_NCUTS] = count <= SEVERAL_TRIES_UP_TO ? TRIES : 1;
  sigset_t termination, before;
  sigemptyset(&termination);
  sigaddset(&termination, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &termination, &before);
  const int status = call(&count, &constraints, graph->start, graph->adjacent, graph->vertex_weight, NULL,
                          graph->edge_weight, &part_count, shares, NULL, options, &cut, part);
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
    if (!divide(ways[way].call, graph, parts, NULL, ALLOWED_PER_MILLE, found)) continue;
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

/* ---- parts to hosts ---- */

/* What is cut between two parts. */
typedef struct contact {
  int32_t from, to;
  int64_t weight;
} contact;

static int by_ends(const void *a, const void *b) {
  const contact *p = a, *q = b;
  if (p->from != q->from) return p->from < q->from ? -1 : 1;
  return p->to < q->to ? -1 : p->to > q->to;
}

/* The contacts of parts, in both directions, ascending; returns how many. */
static int32_t find_contacts(const hc_graph *graph, const int32_t *part, contact **contacts) {
  const idx_t edges = graph->start[graph->count];
  contact *all = hc_alloc((size_t)edges + 1, sizeof *all);
  int32_t count = 0, kept = 0;
  for (idx_t v = 0; v < graph->count; v++)
    for (idx_t e = graph->start[v]; e < graph->start[v + 1]; e++) {
      const int32_t from = part[graph->first[v]], to = part[graph->first[graph->adjacent[e]]];
      if (from != to) all[count++] = (contact){from, to, graph->edge_weight[e]};
    }
  qsort(all, (size_t)count, sizeof *all, by_ends);
  for (int32_t k = 0; k < count; k++) {
    if (kept > 0 && by_ends(&all[kept - 1], &all[k]) == 0)
      all[kept - 1].weight += all[k].weight;
    else
      all[kept++] = all[k];
  }
  *contacts = all;
  return kept;
}

/* The graph of parts, all alike; hc_graph_free. Weights are made to fit METIS's integers. */
static void make_part_graph(hc_graph *graph, int parts, const contact *contacts, int32_t count) {
  int64_t most = 1;
  for (int32_t k = 0; k < count; k++)
    if (contacts[k].weight > most) most = contacts[k].weight;
  const double scale = most > 1000000 ? 1e6 / (double)most : 1.0;
  *graph = (hc_graph){.count = parts,
                      .start = hc_alloc_zero((size_t)parts + 1, sizeof *graph->start),
                      .adjacent = hc_alloc((size_t)count + 1, sizeof *graph->adjacent),
                      .vertex_weight = hc_alloc((size_t)parts, sizeof *graph->vertex_weight),
                      .edge_weight = hc_alloc((size_t)count + 1, sizeof *graph->edge_weight)};
  for (int p = 0; p < parts; p++) graph->vertex_weight[p] = 1;
  for (int32_t k = 0; k < count; k++) {
    graph->start[contacts[k].from + 1]++;
    graph->adjacent[k] = contacts[k].to;
    graph->edge_weight[k] = (idx_t)((double)contacts[k].weight * scale) + 1;
  }
  for (int p = 0; p < parts; p++) graph->start[p + 1] += graph->start[p];
}

/* What a part has in common with a group. */
static int64_t ties(const hc_graph *graph, const int32_t *group, int part, int32_t with) {
  int64_t sum = 0;
  for (idx_t e = graph->start[part]; e < graph->start[part + 1]; e++)
    if (group[graph->adjacent[e]] == with) sum += graph->edge_weight[e];
  return sum;
}

/* Moves parts from groups that have too many to those that have too few, one by one those that lose least. */
static void fit_sizes(const hc_graph *graph, const hc_hosts *hosts, int32_t *group) {
  int32_t *room = hc_alloc((size_t)hosts->count, sizeof *room);
  memcpy(room, hosts->size, (size_t)hosts->count * sizeof *room);
  for (idx_t p = 0; p < graph->count; p++) room[group[p]]--;
  for (int32_t full = 0; full < hosts->count; full++) {
    while (room[full] < 0) {
      int best_part = -1;
      int32_t best_group = -1;
      int64_t best = INT64_MIN;
      for (int p = 0; p < graph->count; p++) {
        if (group[p] != full) continue;
        const int64_t within = ties(graph, group, p, full);
        for (int32_t g = 0; g < hosts->count; g++) {
          const int64_t gain = room[g] > 0 ? ties(graph, group, p, g) - within : INT64_MIN;
          if (gain <= best) continue;
          best = gain;
          best_part = p;
          best_group = g;
        }
      }
      group[best_part] = best_group;
      room[full]++;
      room[best_group]--;
    }
  }
  hc_free(room);
}

void hc_graph_group(const hc_graph *graph, int parts, const int32_t *part, const hc_hosts *hosts,
                    int32_t *group) {
  static const int PER_MILLE = 1;
  for (int p = 0; p < parts; p++) group[p] = hosts->of[p];
  if (hosts->count <= 1 || hosts->count >= parts) return;
  contact *contacts;
  const int32_t count = find_contacts(graph, part, &contacts);
  hc_graph whole;
  make_part_graph(&whole, parts, contacts, count);
  real_t *shares = hc_alloc((size_t)hosts->count, sizeof *shares);
  for (int h = 0; h < hosts->count; h++) shares[h] = (real_t)hosts->size[h] / (real_t)parts;
  idx_t *found = hc_alloc((size_t)parts, sizeof *found);
  if (divide(METIS_PartGraphRecursive, &whole, hosts->count, shares, PER_MILLE, found))
    for (int p = 0; p < parts; p++) group[p] = (int32_t)found[p];
  fit_sizes(&whole, hosts, group);
  hc_free(found);
  hc_free(shares);
  hc_graph_free(&whole);
  hc_free(contacts);
}
